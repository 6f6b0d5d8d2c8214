// Stand-ins for the types of 3DEC's interface that a joint model uses, with the names of the SDK, for building and
// testing without it. QUOIN_3DEC_VERSION selects the version: 3DEC 9 has standard types.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

// A default vector of the SDK is uninitialised. Here it is NaN, so that tests find a model that relies on zeros.
class DVect3 {
 public:
  DVect3() : DVect3(std::numeric_limits<double>::quiet_NaN()) {}
  DVect3(double x, double y, double z = 0.0) : x_(x), y_(y), z_(z) {}
  explicit DVect3(double all) : x_(all), y_(all), z_(all) {}
  double x() const { return x_; }
  double y() const { return y_; }
  double z() const { return z_; }
  double mag() const { return std::sqrt(*this | *this); }
  DVect3 operator+(const DVect3& b) const { return {x_ + b.x_, y_ + b.y_, z_ + b.z_}; }
  DVect3 operator-(const DVect3& b) const { return {x_ - b.x_, y_ - b.y_, z_ - b.z_}; }
  DVect3 operator*(double f) const { return {x_ * f, y_ * f, z_ * f}; }
  DVect3 operator/(double f) const { return {x_ / f, y_ / f, z_ / f}; }
  double operator|(const DVect3& b) const { return x_ * b.x_ + y_ * b.y_ + z_ * b.z_; }  // dot product

 private:
  double x_, y_, z_;
};

#if QUOIN_3DEC_VERSION == 9

using string = std::string;
using uint32 = std::uint32_t;

namespace base {

class Property {
 public:
  Property(double number) : number_(number) {}
  template <class T>
  T to() const {
    return static_cast<T>(number_);
  }

 private:
  double number_;
};

}  // namespace base

// Names of the types of either version for the headers of this folder.
namespace jmodels::shape {
using Text = string;
using Index = uint32;
using Dimension = uint32;
using Value = base::Property;
}  // namespace jmodels::shape

#else

using Int = std::int32_t;
using UInt = std::uint32_t;
using UByte = std::uint8_t;
using Double = double;
using String = std::wstring;

class Variant {
 public:
  Variant(const Double& number) : number_(number) {}
  Double toDouble(bool* success = nullptr) const {
    if (success != nullptr) *success = true;
    return number_;
  }

 private:
  Double number_;
};

namespace jmodels::shape {
using Text = String;
using Index = UInt;
using Dimension = UByte;
using Value = Variant;
}  // namespace jmodels::shape

#endif
