// The few types of 3DEC's interface that a joint model touches: stand-ins under the names that the SDK uses, for
// building and testing without it.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

using Int = std::int32_t;
using UInt = std::uint32_t;
using UByte = std::uint8_t;
using Double = double;
using String = std::wstring;

class DVect3 {
 public:
  DVect3() = default;
  DVect3(double x, double y, double z) : x_(x), y_(y), z_(z) {}
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
  double x_ = 0.0, y_ = 0.0, z_ = 0.0;
};

class Variant {
 public:
  Variant(double number) : number_(number) {}
  double toDouble() const { return number_; }

 private:
  double number_;
};
