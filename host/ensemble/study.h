// A study: a scene, what of it scatters, and how many walls to draw. README.md lists the keys of its file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ensemble/record_suite.h"
#include "random/design.h"
#include "random/distribution.h"
#include "scene/scene.h"

namespace quoin::ensemble {

// One number of a sample: any key of the scene.
struct StudyQuantity {
  std::string name, key;  // "E", "materials.brick.young_modulus"
  random::Distribution distribution;
};

// A limit state: the study gives the probability that it is reached.
struct LimitState {
  std::string name, output;   // output: a column of samples.csv
  std::string where;          // in the file, for messages; empty: one of those that every study has
  double displacement = 0.0;  // limit of a study with records, in place of output, m; 0: collapse
};

// How the samples of a study come to their inputs.
enum class Trials {
  drawn,          // all inputs at random
  one_at_a_time,  // sample 2 k + 1 and 2 k + 2: the k-th input at its 16 % and 84 % quantile, the rest at their means
  exchanged       // rows of n + 2 samples for n inputs: drawn a, drawn b, and a with the k-th input of b
};

struct Study {
  std::string file, title, scene;  // scene: path
  std::uint64_t samples = 100, seed = 1;
  random::Method method = random::Method::monte_carlo;
  std::vector<std::string> overrides;  // overrides of the scene, as --set
  std::vector<StudyQuantity> quantities;
  std::vector<StudyQuantity> scattered;  // properties of joints that scatter, among the overrides
  Trials trials = Trials::drawn;
  std::vector<double> mix;  // correlation of the quantities' normal variables: random::mix_of, row by row
  std::vector<LimitState> limits;
  double crack_opening = 1e-4;      // m: a joint that is open so far is a crack
  std::string start, start_sha256;  // file with the end of another run, where samples begin; empty: at rest
  RecordSuite suite;                // each of its records shakes each of the `samples` walls

  // What is computed by one process at a time: a sample, or a wall under a record, records first. 0: the means, which
  // no record shakes.
  std::uint64_t tasks() const { return samples * (suite.any() ? suite.records.size() : 1); }
  std::uint64_t first_task() const { return suite.any() ? 1 : 0; }
  std::size_t record_of(std::uint64_t task) const { return (task - 1) % suite.records.size(); }
  std::uint64_t wall_of(std::uint64_t task) const { return (task - 1) / suite.records.size() + 1; }

  // What inputs() has in a sample from 1 on; in sample 0 their means.
  std::vector<double> values(std::uint64_t sample) const;
  // Quantities. Unless they are drawn scattered properties too, the same everywhere and independent of each other.
  std::vector<StudyQuantity> inputs() const;
  // What is laid over the scene in that sample.
  std::vector<std::string> overrides_of(std::uint64_t sample) const;
};

// Throws Error(bad_input) with every fault of the file.
Study read_study(const std::string& file);

// What does not go together and no sample would report: fragilities of what is no column of samples.csv, columns of one
// name. Keys that are both set and drawn, too. Throws Error(bad_input) with every fault.
void check_study(const Study& study, const Scene& scene);

}  // namespace quoin::ensemble
