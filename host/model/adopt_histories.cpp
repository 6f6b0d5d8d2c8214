// Start of a model in large motion from the state of a run in small displacements.
#include <fmt/format.h>

#include <map>

#include "base/error.h"
#include "model/contact_frames.h"
#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Distance below which contact points of both models are the same, as a share of the least extent of a block.
constexpr double kSamePlace = 1e-6;

}  // namespace

void set_pose(World& w, int block, const Vector& centre, const Quaternion& turn) {
  Body& body = w.bodies[size_t(w.blocks[size_t(block)].body)];
  body.x = centre;
  body.turn_to(normalized(turn * body.q));
}

void adopt_histories(World& w, const std::vector<PointHistory>& histories) {
  if (w.frames.are_old) find_block_frames(w);
  leave_frames_of_deformed(w);
  std::map<Pair, std::vector<const PointHistory*>> of_pair;
  for (const PointHistory& h : histories)
    of_pair[{std::min(h.block_a, h.block_b), std::max(h.block_a, h.block_b)}].push_back(&h);
  const double near2 = kSamePlace * kSamePlace * w.detection.size * w.detection.size;
  size_t taken = 0;
  for (Family& f : w.contacts.families) {
    for (size_t i = 0; i < f.size(); ++i) {
      Point& p = f.point[i];
      const PointHistory* history = nullptr;
      for (const PointHistory* h : of_pair[{std::min(p.a, p.b), std::max(p.a, p.b)}]) {
        const Vector d = h->position - p.at;  // still the position at the start
        if (dot(d, d) <= near2) history = h;
      }
      // Axes at the start, as in the history.
      const bool on_triangle = p.facet_a >= 0 && !p.on_gridpoints;
      const Matrix start =
          on_triangle ? Matrix{} : (p.on_gridpoints ? start_of_frame(w, p.a) : w.poses.start[size_t(p.a)].r);
      const Vector s = start * p.s, t = start * p.t;
      if (on_triangle) take_axes(p, triangle_frame(w.nodes.x, w.contacts.facets[size_t(p.facet_a)]));

      const Location now = locate(w, p, w.contacts.facets);
      double opening = std::max(0.0, now.jump), slip[2] = {};
      if (history) {
        ++taken;
        opening = history->opening;
        f.normal_jump[i] = history->opening_at_traction;
        f.traction[0][i] = history->traction[0];
        // In the frame of the other block, normal, traction and slip change their signs together: sigma and the opening
        // stay.
        const double sign = history->block_a == p.a ? 1.0 : -1.0;
        const double ss = sign * dot(s, history->s), st = sign * dot(s, history->t);
        const double ts = sign * dot(t, history->s), tt = sign * dot(t, history->t);
        const auto turn = [&](double along_s, double along_t, double& new_s, double& new_t) {
          new_s = ss * along_s + st * along_t, new_t = ts * along_s + tt * along_t;
        };
        turn(history->traction[1], history->traction[2], f.traction[1][i], f.traction[2][i]);
        turn(history->slip[0], history->slip[1], slip[0], slip[1]);
        for (size_t k = 0; k < f.state.size(); ++k) f.state[k][i] = history->state[k];
        for (size_t k = 0; k < f.columns.size(); ++k) f.columns[k].values[i] = history->properties[k];
        for (size_t k = 0; k + 1 < f.state.size(); ++k) {
          if (f.material->api().states[k]->kind != QUOIN_STATE_PAIR_S) continue;
          turn(history->state[k], history->state[k + 1], f.state[k][i], f.state[k + 1][i]);
        }
      }
      p.at = now.at;
      keep_opening(p, now.jump, opening);
      for (int k = 0; k < 2; ++k) f.slid[k][i] = now.slid[k] - slip[k];
    }
  }
  divide_work(w);
  // A stage that begins here takes reactions of supports from these sums.
  for (const Family& f : w.contacts.families) {
    for (size_t i = 0; i < f.size(); ++i) {
      const Vector on_a = force_on_a(w, f, i);
      w.step_sums.contact_force[size_t(f.point[i].a)] += on_a;
      w.step_sums.contact_force[size_t(f.point[i].b)] -= on_a;
    }
  }
  if (taken == histories.size()) return;
  throw Error(Exit::numerical, fmt::format("large motion finds {} of the {} contact points of small displacements",
                                           taken, histories.size()));
}

}  // namespace quoin::blocks
