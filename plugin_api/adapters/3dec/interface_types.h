// Types of 3DEC's interface, deduced from its declarations. 3DEC 7 has a wide String, UInt, UByte for a dimension, and
// Variant with toDouble(). 3DEC 9 has string, uint32 for both integers, and base::Property with to<double>().
// QUOIN_3DEC_VERSION is the version. Outside this file only the version number and getMaxNormalStiffness depend on it.
#pragma once

#include <string_view>
#include <tuple>

#include "jointmodel.h"
#include "state.h"  // jointmodel.h only declares State

namespace quoin::threedec {

inline constexpr unsigned version = QUOIN_3DEC_VERSION;
static_assert(version == 7 || version == 9, "3DEC's interface is known for the versions 7 and 9");

template <class Member>
struct Declared;
template <class R, class... Arguments>
struct Declared<R (jmodels::JointModel::*)(Arguments...)> {
  using Result = R;
  using First = std::tuple_element_t<0, std::tuple<Arguments..., void>>;
};
template <class R, class... Arguments>
struct Declared<R (jmodels::JointModel::*)(Arguments...) const> : Declared<R (jmodels::JointModel::*)(Arguments...)> {};

using Text = Declared<decltype(&jmodels::JointModel::getName)>::Result;
using Value = Declared<decltype(&jmodels::JointModel::getProperty)>::Result;
using Index = Declared<decltype(&jmodels::JointModel::getProperty)>::First;
using Dimension = Declared<decltype(&jmodels::JointModel::run)>::First;

inline Text text(std::string_view ascii) { return Text(ascii.begin(), ascii.end()); }

template <class V>
double number(const V& value) {
  if constexpr (requires { value.toDouble(); })
    return value.toDouble();
  else
    return value.template to<double>();
}

}  // namespace quoin::threedec
