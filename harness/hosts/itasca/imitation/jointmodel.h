// Imitation of the class from which joint models of 3DEC and UDEC derive, as far as a test calls it: our own text. OLD: types
// as in version 7, else as in 9.
#ifndef JOINTMODEL_H
#define JOINTMODEL_H
#include <cmath>
#include <iostream>
#include <string>

struct DVect3 {
  double c[3];
  DVect3(double x = 0, double y = 0, double z = 0) : c{x, y, z} {}
  double x() const { return c[0]; }
  double y() const { return c[1]; }
  double z() const { return c[2]; }
  double mag() const { return std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]); }
  DVect3 operator-(const DVect3 &v) const { return {c[0] - v.c[0], c[1] - v.c[1], c[2] - v.c[2]}; }
};

#ifdef OLD
using Words = std::wstring;
using Whole = unsigned;
using Dim = unsigned char;
class Variant {
  double value;

public:
  Variant(double x) : value(x) {}
  double toDouble() const { return value; }
};
using Content = Variant;
#else
using Words = std::string;
using Whole = unsigned;
using Dim = unsigned;
class Property {
  double value;

public:
  Property(double x) : value(x) {}
  template <class T> T to() const { return T(value); }
};
using Content = Property;
#endif

namespace jmodels {
struct State;
class JointModel {
  Dim valid = 0;

public:
  virtual ~JointModel() {}
  virtual Words getName() const = 0;
  virtual Words getPluginName() const { return getName(); }
  virtual Words getFullName() const = 0;
  virtual Whole getMinorVersion() const { return 0; }
  virtual Words getProperties() const = 0;
  virtual Words getStates() const = 0;
  virtual Content getProperty(Whole index) const = 0;
  virtual void setProperty(Whole, const Content &, Whole = 0) { valid = 0; }
  virtual void save(std::ostream &) const {}
  virtual void restore(std::istream &, Whole) {}
  virtual JointModel *clone() const = 0;
  virtual double getMaxNormalStiffness() const = 0;
  virtual double getMaxShearStiffness() const = 0;
  virtual void copy(const JointModel *) {}
  virtual void run(Dim dimension, State *s) {
    if (valid != dimension) initialize(dimension, s);
  }
  virtual void initialize(Dim dimension, State *) { valid = dimension; }
  virtual Words getEnergies() const { return Words(); }
  virtual double getEnergy(Whole) const { return 0.0; }
  virtual bool getEnergyActivated() const { return false; }
};
} // namespace jmodels
#endif
