// The C ABI around a law written in C++. Of a law's files only its plugin.cpp includes this header. It instantiates
// Plugin<L>, for a type L with these members:
//   struct Material;                                             immutable, made from validated properties
//   static constexpr ... properties, states, initial_states;     spans of metadata; per-point properties first
//   static Material make(const PropertyValues&, Report&);        adds its own faults and warnings
//   static bool initial_state(const Material&, std::string_view id, double* values);
//   static void stiffness_bounds(const Material&, double& normal, double& shear);
//   static void evaluate(const Material&, const Columns&, size_t count, Summary&);   contiguous columns
//   static void evaluate_one(const Material&, const Columns&, Summary&);   one point, only traction and states
//   static void migrate(const Material&, const MigrationPoint& from, MigrationResult& to);   one point
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <string_view>

#include "quoin/quoin.h"
#include "shim/columns.h"
#include "shim/properties.h"

namespace quoin::shim {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline constexpr quoin_property_info number_property(const char* id, const char* symbol, const char* unit,
                                                     const char* description, std::uint32_t flags, double default_value,
                                                     double lower, double upper, const char* default_from = nullptr) {
  return {sizeof(quoin_property_info),
          id,
          symbol,
          unit,
          description,
          QUOIN_PROPERTY_NUMBER,
          flags,
          default_value,
          lower,
          upper,
          default_from,
          nullptr,
          0,
          nullptr};
}

inline constexpr quoin_state_info scalar_state(const char* id, const char* unit, const char* description,
                                               std::uint32_t role, std::uint32_t flags, double lower, double upper) {
  return {sizeof(quoin_state_info), id, unit, description, role, QUOIN_STATE_SCALAR, flags, 0, lower, upper};
}

inline constexpr quoin_convention kConvention = {sizeof(quoin_convention), 1, 1, 1, 1, 1, 1};

// Returns the 64-bit FNV-1a hash of salt and of the states' ids, units, roles and kinds: the law's state_schema.
inline std::uint64_t schema_hash(std::span<const quoin_state_info* const> states, std::string_view salt) {
  std::uint64_t hash = 14695981039346656037ull;
  const auto mix = [&](std::string_view text) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
    hash = (hash ^ 255u) * 1099511628211ull;
  };
  mix(salt);
  for (const quoin_state_info* state : states) {
    mix(state->id);
    mix(state->unit);
    mix(std::to_string(state->role * 16 + state->kind));
  }
  return hash;
}

// Value of point i; without data 0.
inline double at(const quoin_in& column, std::uint64_t i) {
  return column.data == nullptr ? 0.0 : column.data[static_cast<std::int64_t>(i) * column.stride];
}

// One point under the old law: normal jump in m, tractions in Pa, energy in J/m2.
struct MigrationPoint {
  double normal_jump, sigma, tau_s, tau_t, energy_stored;
  const quoin_migration* source;
  std::uint64_t index;
  bool is_finite() const {
    bool finite = true;
    for (const double value : {normal_jump, sigma, tau_s, tau_t, energy_stored}) finite &= std::isfinite(value);
    for (std::uint64_t k = 0; k < source->from_state_count; ++k)
      finite &= std::isfinite(at(source->from_states[k], index));
    return finite;
  }
  // State of the old law with this id; null: it has none.
  const quoin_in* column(std::string_view id) const {
    for (std::uint64_t k = 0; k < source->from_state_count; ++k)
      if (id == source->from_state_ids[k]) return &source->from_states[k];
    return nullptr;
  }
  double state(std::string_view id, double fallback) const {
    const quoin_in* const of_id = column(id);
    return of_id && of_id->data ? at(*of_id, index) : fallback;
  }
  // Whether the old law has one of these states, above 0.
  bool has(std::initializer_list<const char*> damages) const {
    for (const char* id : damages)
      if (state(id, 0.0) > 0.0) return true;
    return false;
  }
  // Whether a joint is open without traction under a law without states of damage: there is no bond.
  bool is_gap() const {
    if (column("failed") || column("xi") || column("xi_t") || column("lambda")) return false;
    return normal_jump > 0.0 && sigma == 0.0 && tau_s == 0.0 && tau_t == 0.0;
  }
};

struct MigrationResult {
  double normal_shift = 0.0;
  double states[kMaxStates] = {};
  double energy_stored = 0.0;
  std::uint32_t status = QUOIN_POINT_OK;
};

template <class L>
class Plugin {
  struct Handle {
    typename L::Material material;
    std::map<std::string, double> numbers;
  };
  static constexpr std::size_t kStates = L::states.size();
  static_assert(kStates <= kMaxStates);

  // Points of a tile, the local copy in which run_tile evaluates strided columns.
  static constexpr std::size_t kTile = 64;

  static const Handle& get(const quoin_material* material) { return *reinterpret_cast<const Handle*>(material); }

  // Calls body and turns every exception into a status: none crosses the ABI.
  template <class F>
  static quoin_status guarded(quoin_text* text, F&& body) noexcept {
    try {
      return body();
    } catch (const std::bad_alloc&) {
      return QUOIN_ERROR_MEMORY;
    } catch (const std::exception& error) {
      try {
        write_text(text, error.what());
      } catch (...) {
      }
      return QUOIN_ERROR_INTERNAL;
    } catch (...) {
      return QUOIN_ERROR_INTERNAL;
    }
  }

 public:
  static quoin_status create_material(const quoin_law* law, std::uint64_t count,
                                      const quoin_property_value* const* values, quoin_material** out,
                                      quoin_text* text) {
    if (out != nullptr) *out = nullptr;
    if (law == nullptr || (count > 0 && values == nullptr)) return QUOIN_ERROR_ARGUMENT;
    return guarded(text, [&]() -> quoin_status {
      Report report;
      const PropertyValues properties(L::properties, {values, static_cast<std::size_t>(count)}, report);
      const auto refused = [&] {
        write_text(text, Report::join(report.faults));
        return QUOIN_ERROR_PROPERTY;
      };
      if (report.lacks_value) return refused();
      // The law's own conditions are checked even when single values are out of bounds, so that one message has all
      // faults.
      typename L::Material material = L::make(properties, report);
      if (!report.faults.empty()) return refused();
      write_text(text, Report::join(report.warnings));
      if (out != nullptr) {
        *out = reinterpret_cast<quoin_material*>(new Handle{std::move(material), properties.numbers()});
      }
      return QUOIN_OK;
    });
  }

  static void destroy_material(quoin_material* material) { delete reinterpret_cast<Handle*>(material); }

  static quoin_status material_number(const quoin_material* material, const char* id, double* value) {
    if (material == nullptr || id == nullptr || value == nullptr) return QUOIN_ERROR_ARGUMENT;
    return guarded(nullptr, [&]() -> quoin_status {
      const auto& numbers = get(material).numbers;
      const auto found = numbers.find(id);
      if (found == numbers.end()) return QUOIN_ERROR_ARGUMENT;
      *value = found->second;
      return QUOIN_OK;
    });
  }

  static quoin_status initial_state(const quoin_material* material, const char* id, double* values) {
    if (material == nullptr || id == nullptr || (values == nullptr && kStates > 0)) return QUOIN_ERROR_ARGUMENT;
    return L::initial_state(get(material).material, id, values) ? QUOIN_OK : QUOIN_ERROR_ARGUMENT;
  }

  static quoin_status stiffness_bounds(const quoin_material* material, quoin_stiffness_bounds* bounds) {
    if (material == nullptr || bounds == nullptr || bounds->struct_size < sizeof(quoin_stiffness_bounds)) {
      return QUOIN_ERROR_ARGUMENT;
    }
    L::stiffness_bounds(get(material).material, bounds->normal, bounds->shear);
    return QUOIN_OK;
  }

  static quoin_status evaluate(const quoin_material* material, quoin_batch* batch) {
    if (material == nullptr || batch == nullptr || batch->struct_size < QUOIN_BATCH_SIZE_1_0)
      return QUOIN_ERROR_ARGUMENT;
    if (batch->count == 0) {
      put_summary({}, *batch);
      return QUOIN_OK;
    }
    if (kStates > 0 && (batch->state_old == nullptr || batch->state_new == nullptr)) return QUOIN_ERROR_ARGUMENT;
    if (batch->count == 1 && !needs_more(*batch)) return run_one(get(material).material, *batch);
    return guarded(nullptr, [&]() { return run(get(material).material, *batch); });
  }

  static quoin_status migrate_state(const quoin_material* material, quoin_migration* m, quoin_text* text) {
    if (material == nullptr || m == nullptr || m->struct_size < sizeof(quoin_migration) || m->from_law == nullptr)
      return QUOIN_ERROR_ARGUMENT;
    if (m->count > 0 && !is_complete(*m)) return QUOIN_ERROR_ARGUMENT;
    return guarded(text, [&]() -> quoin_status {
      const std::uint64_t schema = schema_hash(L::states, L::id);
      if (std::string_view(m->from_law) == L::id && m->from_schema != schema) {
        write_text(text, "the states have the schema " + std::to_string(m->from_schema) + " of another version of " +
                             L::id + ", whose schema is " + std::to_string(schema) +
                             " here; use the version that wrote them");
        return QUOIN_ERROR_VERSION;
      }
      m->failed_count = 0;
      std::uint64_t not_finite = 0;
      for (std::uint64_t i = 0; i < m->count; ++i) {
        const MigrationPoint from{at(m->normal_jump, i),
                                  at(m->traction[0], i),
                                  at(m->traction[1], i),
                                  at(m->traction[2], i),
                                  at(m->energy_stored, i),
                                  m,
                                  i};
        MigrationResult to;
        if (from.is_finite()) {
          L::migrate(get(material).material, from, to);
        } else {
          to.status = QUOIN_POINT_FAILED;
          ++not_finite;
        }
        const auto put = [&](const auto& column, auto value) {
          if (column.data != nullptr) column.data[static_cast<std::int64_t>(i) * column.stride] = value;
        };
        put(m->normal_shift, to.normal_shift);
        for (std::size_t k = 0; k < kStates; ++k) put(m->state_new[k], to.states[k]);
        put(m->energy_jump, to.status == QUOIN_POINT_FAILED ? 0.0 : to.energy_stored - from.energy_stored);
        put(m->status, to.status);
        m->failed_count += to.status == QUOIN_POINT_FAILED ? 1 : 0;
      }
      if (m->failed_count == 0) return QUOIN_OK;
      const std::string all = " of " + std::to_string(m->count) + " points ";
      std::vector<std::string> reasons;
      if (m->failed_count > not_finite)
        reasons.push_back(std::to_string(m->failed_count - not_finite) + all +
                          "carry a traction outside the strength of this law and cannot be taken over; unload them or "
                          "raise the strength");
      if (not_finite > 0)
        reasons.push_back(std::to_string(not_finite) + all +
                          "have a jump, traction, energy or state that is not finite; take over before that happens");
      write_text(text, Report::join(reasons));
      return QUOIN_ERROR_UNSUPPORTED;
    });
  }

 private:
  // Whether a migration has its ids and required columns, and no output of several points with stride 0.
  static bool is_complete(const quoin_migration& m) {
    bool complete = m.normal_jump.data != nullptr && m.normal_shift.data != nullptr;
    for (const quoin_in& column : m.traction) complete = complete && column.data != nullptr;
    if (m.from_state_count > 0) complete = complete && m.from_states != nullptr && m.from_state_ids != nullptr;
    for (std::uint64_t k = 0; complete && k < m.from_state_count; ++k) complete = m.from_state_ids[k] != nullptr;
    const auto distinct = [&](const auto& column) {
      return column.data == nullptr || column.stride != 0 || m.count == 1;
    };
    complete = complete && distinct(m.normal_shift) && distinct(m.energy_jump) && distinct(m.status);
    if (kStates > 0) complete = complete && m.state_new != nullptr;
    for (std::size_t k = 0; complete && k < kStates; ++k) {
      const bool optional = L::states[k]->role != QUOIN_ROLE_HISTORY;
      complete = distinct(m.state_new[k]) && (optional || m.state_new[k].data != nullptr);
    }
    return complete;
  }

  static constexpr int kInputs = kStateOld + static_cast<int>(kStates);   // number of inputs without property columns
  static constexpr int kOutputs = kStateNew + static_cast<int>(kStates);  // number of tractions and states
  static constexpr int kProperties = static_cast<int>(L::properties.size());

  // The batch's columns in the order of Columns, each with its stride. Not initialised as a whole: in a batch of a few
  // points that would cost a measurable time.
  struct Views {
    quoin_in in[kInCount];
    quoin_out out[kOutCount];
    quoin_out_u32 words[2];  // flags, status
    bool property_columns, extras, more_outputs;
    bool contiguous;  // all strides are 1 and no flags or status are requested: the kernel can use the caller's memory

    // Call f(index in Columns, view) for every input, or for every output in doubles, that this batch may have.
    template <class F>
    void for_inputs(const F& f) const {
      for (int k = 0; k < kInputs; ++k) f(k, in[k]);
      if (!property_columns) return;
      for (int k = kProperty; k < kProperty + kProperties; ++k) f(k, in[k]);
    }
    template <class F>
    void for_outputs(const F& f) const {
      for (int k = 0; k < kOutputs; ++k) f(k, out[k]);
      if (!extras) return;
      for (int k = kEnergyStored; k < kFlags; ++k) f(k, out[k]);
    }
  };

  // Returns the column of a per-point property, which is its index in the law's metadata. -1: no per-point property has
  // this id.
  static int property_column(const char* property_id) {
    // Most hosts pass the pointer of the metadata's own id. Comparing pointers first saves comparing texts in every
    // batch.
    for (std::size_t k = 0; k < L::properties.size(); ++k) {
      const quoin_property_info& info = *L::properties[k];
      if (property_id == info.id && (info.flags & QUOIN_PROPERTY_PER_POINT) != 0) return static_cast<int>(k);
    }
    for (std::size_t k = 0; k < L::properties.size(); ++k) {
      const quoin_property_info& info = *L::properties[k];
      if (std::string_view(property_id) == info.id)
        return (info.flags & QUOIN_PROPERTY_PER_POINT) != 0 ? static_cast<int>(k) : -1;
    }
    return -1;
  }

  // Fills in views from batch. Returns QUOIN_ERROR_ARGUMENT if a required column is missing or an output of several
  // points has stride 0.
  static quoin_status collect(const quoin_batch& batch, Views& views) {
    views.in[kNormalJump] = batch.normal_jump;
    for (int k = 0; k < 2; ++k) views.in[kSlipIncrement + k] = batch.slip_increment[k];
    for (int k = 0; k < 3; ++k) views.in[kTractionOld + k] = batch.traction_old[k];
    for (int k = 0; k < 3; ++k) views.out[kTractionNew + k] = batch.traction_new[k];
    bool complete = true;
    for (int k = 0; k < kStateOld; ++k) complete &= views.in[k].data != nullptr;
    for (int k = 0; k < kStateNew; ++k) complete &= views.out[k].data != nullptr;
    for (std::size_t k = 0; k < kStates; ++k) {
      const bool missing = batch.state_old[k].data == nullptr || batch.state_new[k].data == nullptr;
      views.in[kStateOld + k] = missing ? quoin_in{} : batch.state_old[k];
      views.out[kStateNew + k] = missing ? quoin_out{} : batch.state_new[k];
      complete &= !(missing && L::states[k]->role == QUOIN_ROLE_HISTORY);
    }
    if (!complete && batch.count > 0) return QUOIN_ERROR_ARGUMENT;

    views.property_columns = batch.property_column_count > 0;
    if (views.property_columns) {
      if (batch.property_columns == nullptr) return QUOIN_ERROR_ARGUMENT;
      for (int k = 0; k < kProperties; ++k) views.in[kProperty + k] = {};
      for (std::uint64_t c = 0; c < batch.property_column_count; ++c) {
        const quoin_property_column& column = batch.property_columns[c];
        const int index = column.id == nullptr ? -1 : property_column(column.id);
        const bool is_given_twice = index >= 0 && views.in[kProperty + index].data != nullptr;
        if (index < 0 || column.values.data == nullptr || is_given_twice) return QUOIN_ERROR_ARGUMENT;
        views.in[kProperty + index] = column.values;
      }
    }

    views.words[0] = batch.flags;
    views.words[1] = batch.status;
    views.more_outputs = has_optional_outputs(batch);
    views.extras = views.property_columns | views.more_outputs;
    if (views.extras) {
      views.out[kEnergyStored] = batch.energy_stored;
      for (int k = 0; k < 4; ++k) views.out[kDissipated + k] = batch.dissipated[k];
      for (int k = 0; k < 9; ++k) views.out[kTangent + k] = batch.tangent[k];
      for (int k = 0; k < QUOIN_DAMAGE_COUNT; ++k)
        views.out[kDamage + k] = has_damage(batch) ? batch.damage[k] : quoin_out{};
    }

    // Without branches, which would take most of the time of small batches.
    views.contiguous = (batch.flags.data == nullptr) & (batch.status.data == nullptr);
    const auto follow = [&](int, const auto& view) { views.contiguous &= (view.data == nullptr) | (view.stride == 1); };
    views.for_inputs(follow);
    views.for_outputs(follow);
    if (views.contiguous || batch.count <= 1) return QUOIN_OK;
    bool distinct = true;
    const auto check = [&](const auto& view) { distinct = distinct && (view.data == nullptr || view.stride != 0); };
    views.for_outputs([&](int, const quoin_out& view) { check(view); });
    for (const quoin_out_u32& view : views.words) check(view);
    return distinct ? QUOIN_OK : QUOIN_ERROR_ARGUMENT;
  }

  // True if outputs beyond tractions and states are requested or a property is given point by point.
  static bool needs_more(const quoin_batch& batch) {
    return (batch.property_column_count > 0) | has_optional_outputs(batch);
  }
  // True if outputs beyond tractions and states are requested. Without branches, which would cost time in small
  // batches.
  static bool has_optional_outputs(const quoin_batch& batch) {
    bool more = (batch.flags.data != nullptr) | (batch.status.data != nullptr) | (batch.energy_stored.data != nullptr);
    for (const quoin_out& view : batch.dissipated) more |= view.data != nullptr;
    for (const quoin_out& view : batch.tangent) more |= view.data != nullptr;
    if (has_damage(batch)) {
      for (const quoin_out& view : batch.damage) more |= view.data != nullptr;
    }
    return more;
  }
  // False for a host of ABI version 1.0, whose quoin_batch has no damage columns.
  static bool has_damage(const quoin_batch& batch) { return batch.struct_size >= sizeof(quoin_batch); }

  // Properties of the columns that point_at has set.
  struct Pointed {
    bool complete, contiguous;  // no required column is missing; every stride is 1
  };
  // Sets columns to the caller's jumps, tractions and states, and to no other outputs. Without branches, which would
  // take most of the time of small batches.
  [[gnu::always_inline]] static Pointed point_at(const quoin_batch& batch, Columns& columns) {
    columns.property_columns = columns.extras = false;
    columns.in_place = true;
    Pointed is{true, true};
    const auto note = [&](const auto& view) {
      is.complete &= view.data != nullptr;
      is.contiguous &= view.stride == 1;
      return view.data;
    };
    columns.in[kNormalJump] = note(batch.normal_jump);
    for (int k = 0; k < 2; ++k) columns.in[kSlipIncrement + k] = note(batch.slip_increment[k]);
    for (int k = 0; k < 3; ++k) columns.in[kTractionOld + k] = note(batch.traction_old[k]);
    for (int k = 0; k < 3; ++k) columns.out[kTractionNew + k] = note(batch.traction_new[k]);
    for (std::size_t k = 0; k < kStates; ++k) {
      const quoin_in& old = batch.state_old[k];
      const quoin_out& now = batch.state_new[k];
      const bool missing = (old.data == nullptr) | (now.data == nullptr);
      columns.in[kStateOld + k] = missing ? nullptr : old.data;
      columns.out[kStateNew + k] = missing ? nullptr : now.data;
      columns.in_place &= missing | (old.data == now.data);
      is.contiguous &= missing | ((old.stride == 1) & (now.stride == 1));
      is.complete &= !missing | (L::states[k]->role != QUOIN_ROLE_HISTORY);
    }
    return is;
  }

  // Evaluates a batch of one point in the caller's memory. Hosts without batches call this for every contact and step,
  // so strides are not read and nothing is copied.
  static quoin_status run_one(const typename L::Material& material, quoin_batch& batch) noexcept {
    Columns columns;
    if (!point_at(batch, columns).complete) return QUOIN_ERROR_ARGUMENT;
    Summary summary;
    L::evaluate_one(material, columns, summary);
    put_summary(summary, batch);
    return QUOIN_OK;
  }

  static void put_summary(const Summary& summary, quoin_batch& batch) {
    batch.clamped_count = summary.clamped;
    batch.failed_count = summary.failed;
    batch.worst_status = summary.failed > 0    ? QUOIN_POINT_FAILED
                         : summary.clamped > 0 ? QUOIN_POINT_CLAMPED
                                               : QUOIN_POINT_OK;
    batch.any_yielding = summary.yielding ? 1u : 0u;
  }

  static quoin_status run(const typename L::Material& material, quoin_batch& batch) {
    // The usual request in every step: tractions and states of whole vectors, in contiguous memory of the host.
    Columns columns;
    const std::size_t count = static_cast<std::size_t>(batch.count);
    if (count % kMaxLanes == 0 && !needs_more(batch)) {
      const Pointed is = point_at(batch, columns);
      if (is.complete && is.contiguous) {
        Summary summary;
        L::evaluate(material, columns, count, summary);
        put_summary(summary, batch);
        return QUOIN_OK;
      }
    }
    return run_views(material, batch, count);
  }

  static quoin_status run_views(const typename L::Material& material, quoin_batch& batch, std::size_t count) {
    Views views;
    const quoin_status status = collect(batch, views);
    if (status != QUOIN_OK) return status;

    Summary summary;
    std::size_t first = 0;
    if (count >= kMaxLanes && views.contiguous) {
      first = count / kMaxLanes * kMaxLanes;
      run_direct(material, views, first, summary);
    }
    for (; first < count; first += kTile) run_tile(material, views, first, std::min(kTile, count - first), summary);
    put_summary(summary, batch);
    return QUOIN_OK;
  }

  // Evaluates the first count points in the caller's memory.
  static void run_direct(const typename L::Material& material, const Views& views, std::size_t count,
                         Summary& summary) {
    Columns columns;
    columns.property_columns = views.property_columns;
    columns.extras = views.extras;
    columns.more_outputs = views.more_outputs;
    views.for_inputs([&](int k, const quoin_in& view) { columns.in[k] = view.data; });
    views.for_outputs([&](int k, const quoin_out& view) { columns.out[k] = view.data; });
    columns.out[kFlags] = columns.out[kStatus] = nullptr;
    columns.in_place = true;
    for (std::size_t k = 0; k < kStates; ++k) {
      columns.in_place &= columns.in[kStateOld + k] == columns.out[kStateNew + k];
    }
    L::evaluate(material, columns, count, summary);
  }

  // Evaluates the points from first on in local copies: for strided columns, and for the points after the last whole
  // vector.
  static void run_tile(const typename L::Material& material, const Views& views, std::size_t first, std::size_t count,
                       Summary& summary) {
    alignas(64) double in[kInCount][kTile];
    alignas(64) double out[kOutCount][kTile];
    Columns columns;
    columns.property_columns = views.property_columns;
    columns.extras = views.extras;
    columns.more_outputs = views.more_outputs;
    columns.in_place = false;
    const std::size_t padded = (count + kMaxLanes - 1) / kMaxLanes * kMaxLanes;
    views.for_inputs([&](int k, const quoin_in& view) {
      columns.in[k] = view.data == nullptr ? nullptr : in[k];
      if (view.data == nullptr) return;
      const double* const from = view.data + static_cast<std::int64_t>(first) * view.stride;
      for (std::size_t i = 0; i < count; ++i) in[k][i] = from[static_cast<std::int64_t>(i) * view.stride];
      for (std::size_t i = count; i < padded; ++i) in[k][i] = in[k][count - 1];
    });
    views.for_outputs([&](int k, const quoin_out& view) { columns.out[k] = view.data == nullptr ? nullptr : out[k]; });
    for (int w = 0; w < 2; ++w) columns.out[kFlags + w] = views.words[w].data == nullptr ? nullptr : out[kFlags + w];
    L::evaluate(material, columns, count, summary);
    const auto put = [&](int k, const auto& view) {
      if (view.data == nullptr) return;
      auto* const to = view.data + static_cast<std::int64_t>(first) * view.stride;
      using Number = std::remove_reference_t<decltype(*to)>;
      for (std::size_t i = 0; i < count; ++i)
        to[static_cast<std::int64_t>(i) * view.stride] = static_cast<Number>(out[k][i]);
    };
    views.for_outputs(put);
    for (int w = 0; w < 2; ++w) put(kFlags + w, views.words[w]);
  }
};

// Returns the library of the one law L; null, with the reason in text, for a host of another major ABI version.
template <class L>
const quoin_library* single_law_library(const quoin_host_info* host, quoin_text* text) {
  static const quoin_law law = {sizeof(quoin_law),
                                L::id,
                                L::name,
                                QUOIN_LAW_VERSION,
                                L::citation,
                                L::description,
                                L::capabilities,
                                &kConvention,
                                L::properties.size(),
                                L::properties.data(),
                                L::states.size(),
                                L::states.data(),
                                L::initial_states.size(),
                                L::initial_states.data(),
                                schema_hash(L::states, L::id),
                                &Plugin<L>::create_material,
                                &Plugin<L>::destroy_material,
                                &Plugin<L>::material_number,
                                &Plugin<L>::initial_state,
                                &Plugin<L>::stiffness_bounds,
                                &Plugin<L>::evaluate,
                                &Plugin<L>::migrate_state};
  static const quoin_law* const laws[] = {&law};
  static const quoin_library library = {
      sizeof(quoin_library), QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, L::id, QUOIN_LAW_VERSION, 1, laws, nullptr};
  if (host == nullptr || host->struct_size < sizeof(quoin_host_info) || host->abi_major != QUOIN_ABI_MAJOR) {
    write_text(text, "this library speaks Quoin ABI " + std::to_string(QUOIN_ABI_MAJOR) + "." +
                         std::to_string(QUOIN_ABI_MINOR) + ", the host " +
                         (host == nullptr ? "none" : std::to_string(host->abi_major)) +
                         "; use a library and a host of the same major version");
    return nullptr;
  }
  return &library;
}

}  // namespace quoin::shim
