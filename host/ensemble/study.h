// A study: a scene, its random quantities, and the number of samples. README.md lists the keys of its file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ensemble/record_suite.h"
#include "random/design.h"
#include "random/distribution.h"
#include "scene/scene.h"

namespace quoin::ensemble {

// A random number: any key of the scene.
struct StudyQuantity {
  std::string name, key;  // "E", "materials.brick.young_modulus"
  random::Distribution distribution;
};

// A limit state. The study returns the probability that it is reached.
struct LimitState {
  std::string name, output;   // output: a column of samples.csv
  std::string where;          // place in the file, for messages; empty: a limit of every study
  double displacement = 0.0;  // limit of a study with records, which replaces output, m; 0: collapse
};

// Inputs of the samples of a study.
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
  std::vector<StudyQuantity> scattered;  // random properties of joints, of [set] and of the scene
  Trials trials = Trials::drawn;
  std::vector<PropertyCorrelation> correlation;  // of quantities, by their names
  std::vector<double> mix;  // correlation of the quantities' normal variables: random::mix_of, row by row
  std::vector<LimitState> limits;
  double crack_opening = 1e-4;      // opening from which a joint counts as cracked, m
  std::string start, start_sha256;  // file with the end state of another run, where samples begin; empty: at rest
  RecordSuite suite;                // records, each of which acts on each of the `samples` walls

  // Number of tasks. A task is a sample, or a wall under a record; records vary fastest. Task 0 is the means, without a
  // record.
  std::uint64_t tasks() const { return samples * (suite.any() ? suite.records.size() : 1); }
  std::uint64_t first_task() const { return suite.any() ? 1 : 0; }
  std::size_t record_of(std::uint64_t task) const { return (task - 1) % suite.records.size(); }
  std::uint64_t wall_of(std::uint64_t task) const { return (task - 1) / suite.records.size() + 1; }

  // Values of inputs() in a sample from 1; in sample 0 their means. `samples` is final from the first call on.
  std::vector<double> values(std::uint64_t sample) const;
  // Makes the design, as the first call of values does. Called before processes begin, each of which would make it.
  void draw() const;
  // Quantities. Unless inputs are drawn, also random properties of joints, each uniform and independent of the others.
  std::vector<StudyQuantity> inputs() const;
  // Overrides of the scene in a sample.
  std::vector<std::string> overrides_of(std::uint64_t sample) const;

  mutable std::optional<random::Design> design;  // by draw()
};

// Reads a study. Throws Error(bad_input) with all faults of the file.
Study read_study(const std::string& file);
// Adds the random properties of the scene itself to `scattered`.
void add_scatter_of(const Scene& scene, Study& study);

// Makes the checks that no sample makes. Fragilities need outputs in samples.csv, columns different names, and no key
// may be both set and random. Throws Error(bad_input) with all faults.
void check_study(const Study& study, const Scene& scene);

}  // namespace quoin::ensemble
