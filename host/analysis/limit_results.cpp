// Results of limit analysis: joints and members of a solution, and limit.json.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/limit_of_scene.h"
#include "results/json_file.h"

namespace quoin {
namespace {

using geometry::Vector;

nlohmann::ordered_json json_of(const LimitWithoutDilation& without, const char* what) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const SettledLimit& start : without.start)
    json.push_back({{"from", start.from},
                    {"settled", start.settled},
                    {what, start.multiplier},
                    {"beyond_friction", start.beyond},
                    // Where little slides, the excess is no share of its friction.
                    {"share_beyond_friction", start.share_beyond < 1.0 ? nlohmann::ordered_json(start.share_beyond)
                                                                       : nlohmann::ordered_json(nullptr)},
                    {"spread", start.spread},
                    {"problems", start.problems}});
  return json;
}

nlohmann::ordered_json json_of_moving(const SceneLimit& limit) {
  nlohmann::ordered_json json{{"force_N", geometry::array(limit.moving_force)}, {"worst", limit.worst}};
  for (const MovingLimit& here : limit.moving)
    json["positions"].push_back(
        {{"position_m", geometry::array(here.position)},
         {"at_m", geometry::array(here.at)},
         {"block", limit.labels[static_cast<std::size_t>(here.block)]},
         {"multiplier", here.multiplier ? nlohmann::ordered_json(*here.multiplier) : nlohmann::ordered_json(nullptr)}});
  return json;
}

// What a joint does: "opens", "hinges", "slides", "crushes", or several with "and" between them.
std::string text_of(const JointMotion& m) {
  std::string text = m.hinges ? "hinges" : m.opening > 0.0 ? "opens" : "";
  const auto add = [&](double rate, const char* what) {
    if (rate > 0.0) text += (text.empty() ? "" : " and ") + std::string(what);
  };
  add(m.sliding, "slides"), add(m.crushing, "crushes");
  return text;
}

nlohmann::ordered_json json_of_joints(const SceneLimit& limit) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const JointMotion& m : joint_motions(limit))
    json.push_back({{"family", limit.families[static_cast<std::size_t>(m.family)]},
                    {"blocks", {m.a, m.b}},
                    {"names", {limit.names[static_cast<std::size_t>(m.a)], limit.names[static_cast<std::size_t>(m.b)]}},
                    {"motion", text_of(m)},
                    {"opening", m.opening},
                    {"sliding", m.sliding},
                    {"crushing", m.crushing}});
  return json;
}

std::optional<double> settled(const std::optional<LimitWithoutDilation>& without) {
  if (!without || !without->settled) return std::nullopt;
  return without->multiplier;
}

}  // namespace

std::vector<int> moving_without_load(const SceneLimit& limit) {
  constexpr double kNone = 1e-6, kMoves = 1e-4;  // shares of the weight, and of the largest velocity
  std::vector<int> blocks;
  if (!limit.margin || std::abs(*limit.margin) > kNone || !limit.limit) return blocks;
  for (std::size_t b = 0; b < limit.limit->velocity.size(); ++b) {
    const auto& [v, w] = limit.limit->velocity[b];
    if (norm(v) > kMoves || norm(w) > kMoves) blocks.push_back(static_cast<int>(b));
  }
  return blocks;
}

std::vector<JointMotion> joint_motions(const SceneLimit& limit) {
  constexpr double kMoves = 1e-3;  // rate of a joint over the largest, that counts as motion
  std::vector<JointMotion> joints;
  if (!limit.limit || limit.limit->velocity.empty()) return joints;
  std::map<std::array<int, 3>, std::vector<std::array<double, 3>>> rates;  // opening, sliding, closing of each point
  double largest = 0.0;
  for (std::size_t i = 0; i < limit.point_count; ++i) {
    const LimitPoint& p = limit.problem.points[i];
    const auto motion = [&](int block) {
      const Wrench& v = limit.limit->velocity[static_cast<std::size_t>(block)];
      return v.force + cross(v.moment, p.position - limit.problem.blocks[static_cast<std::size_t>(block)].centre);
    };
    const Vector jump = motion(p.b) - motion(p.a);
    const double apart = dot(jump, p.n), sliding = norm(jump - apart * p.n);
    rates[{p.a, p.b, p.family}].push_back({apart - p.friction * sliding, sliding, -apart});
    largest = std::max({largest, std::abs(apart), sliding});
  }
  for (const auto& [joint, points] : rates) {
    JointMotion m{joint[0], joint[1], joint[2]};
    for (const auto& [opening, sliding, crushing] : points) {
      m.opening = std::max(m.opening, opening / largest), m.sliding = std::max(m.sliding, sliding / largest);
      m.crushing = std::max(m.crushing, crushing / largest);
      m.hinges = m.hinges || opening <= kMoves * largest;
    }
    m.hinges = m.hinges && m.opening > kMoves;
    for (double* rate : {&m.opening, &m.sliding, &m.crushing}) *rate = *rate > kMoves ? *rate : 0.0;
    if (std::max({m.opening, m.sliding, m.crushing}) > 0.0) joints.push_back(m);
  }
  std::ranges::stable_sort(joints, std::greater{}, [](const JointMotion& m) {
    return std::max({m.opening, m.sliding, m.crushing});
  });
  return joints;
}

MemberForce largest_force(const LimitMember& member, const LimitResult& result) {
  constexpr double kAll = 1.0 - 1e-6;  // share of a strength that counts as reaching it
  MemberForce found;
  for (std::size_t k = 0; k < member.of.size(); ++k) {
    double force = result.member_force[member.of[k]] / member.over[k];
    if (member.what == "anchor_N_per_m") force = std::max(0.0, force);  // bearing has no limit
    if (std::abs(force) >= found.largest) found.largest = std::abs(force), found.strength = member.strength[k];
    if (std::abs(force) >= kAll * member.strength[k] && member.strength[k] > 0.0) ++found.at_strength;
  }
  return found;
}

nlohmann::ordered_json json_of(const std::string& scene, const SceneLimit& limit, const LimitOptions& options) {
  nlohmann::ordered_json json;
  json["scene"] = scene;
  json["multiplier"] = limit.limit ? nlohmann::ordered_json(limit.limit->multiplier) : nlohmann::ordered_json(nullptr);
  json["multiplier_without_dilation"] = number_or_null(settled(limit.without_dilation));
  json["gap"] = limit.limit ? nlohmann::ordered_json(limit.limit->gap) : nlohmann::ordered_json(nullptr);
  if (limit.without_dilation) {
    json["without_dilation"] = json_of(*limit.without_dilation, "multiplier");
    json["without_dilation_apart"] = limit.without_dilation->apart;
  }
  const Stands& stands = limit.stands;
  json["stands"] = stands.stands;
  json["carried"] = stands.carried;
  json["margin"] = number_or_null(limit.margin);
  if (limit.margin && norm(limit.margin_direction) > 0.0)
    json["margin_direction"] = geometry::array(limit.margin_direction);
  json["smallest_friction_scale"] = number_or_null(stands.friction);
  json["smallest_friction_scale_without_dilation"] = number_or_null(settled(limit.friction));
  if (limit.friction) {
    json["friction_without_dilation"] = json_of(*limit.friction, "friction_scale");
    json["friction_without_dilation_apart"] = limit.friction->apart;
  }
  json["out_of_balance"] = nlohmann::ordered_json::array();
  for (const int b : stands.out_of_balance) json["out_of_balance"].push_back(limit.labels[static_cast<std::size_t>(b)]);
  json["moves_without_load"] = nlohmann::ordered_json::array();
  for (const int b : moving_without_load(limit))
    json["moves_without_load"].push_back(limit.labels[static_cast<std::size_t>(b)]);
  if (!limit.moving.empty()) json["moving"] = json_of_moving(limit);
  if (limit.direction && limit.moving.empty())
    json["direction"] = geometry::array(*limit.direction);
  else
    json["direction"] = nullptr;
  json["multiplied"] = limit.moving.empty() ? name_of(options.multiplied) : "moving_load";
  json["stage"] = limit.stage;
  if (options.multiplied != Multiplied::weight && options.multiplied != Multiplied::motion)
    json["multiplied_force_N"] = geometry::array(limit.live_force);
  json["given_multiplier"] = options.given;
  json["gravity_m_s2"] = geometry::array(limit.gravity);
  json["symmetric_mechanisms_only"] = limit.halved;
  json["blocks"] = limit.block_count, json["contact_points"] = limit.point_count;
  json["facets"] = limit.limit ? limit.limit->facets : options.settings.facets;
  json["moving_joints"] = json_of_joints(limit);
  if (limit.limit && !limit.tie_names.empty())
    json["tie_force_N"] =
        std::vector<double>(limit.limit->member_force.begin(),
                            limit.limit->member_force.begin() + static_cast<std::ptrdiff_t>(limit.tie_names.size()));
  if (!limit.limit || limit.members.empty()) return json;
  for (const LimitMember& member : limit.members) {
    const MemberForce force = largest_force(member, *limit.limit);
    json["member_forces"].push_back({{"member", member.label},
                                     {"what", member.what},
                                     {"largest", force.largest},
                                     {"strength", std::isfinite(force.strength) ? nlohmann::ordered_json(force.strength)
                                                                                : nlohmann::ordered_json(nullptr)},
                                     {"at_strength", force.at_strength},
                                     {"of", member.of.size()}});
  }
  return json;
}

}  // namespace quoin
