// Joint model "asperity" of 3DEC and UDEC: the C API of libasperity for a subcontact.
//
// Build it with the headers of your program as jmodelasperity001 (Windows: .dll, Linux: .so) and link libasperity; types are
// taken from these headers, so that it suits 7 and 9. Forces are area times traction, against it in sign: compression is
// positive, and a shear force resists the displacement. Properties p1, p2, ... are PROPS; n-x to t-z are N and Tx in the axes
// of the shear vectors (default: their third and first axis). The rest is read only.
#include "jointmodel.h"
#include "state.h"

#include "asperity.h"
#include <algorithm>
#include <cmath>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#ifdef _WIN32
#define EXPORTED extern "C" __declspec(dllexport)
#else
#define EXPORTED extern "C" __attribute__((visibility("default")))
#endif

namespace jmodels {

template <class C, class D> D first_of(void (C::*)(D, State *));
using Base = JointModel;
using Text = decltype(std::declval<const Base &>().getName());
using Number = decltype(std::declval<const Base &>().getMinorVersion());
using Value = decltype(std::declval<const Base &>().getProperty(1));
using Dimension = decltype(first_of(&Base::run));
using Vector = decltype(State::shear_force_);

template <class V> auto number(const V &value, int) -> decltype(value.template to<double>()) {
  return value.template to<double>();
}
template <class V> auto number(const V &value, long) -> decltype(value.toDouble()) { return value.toDouble(); }

inline Text text(const std::string &words) {
  return Text(std::basic_string<typename Text::value_type>(words.begin(), words.end()).c_str());
}

class Asperity : public JointModel {
  static constexpr unsigned constants = 96, axes = 6, shown = 4;
  static constexpr double out_of_plane = 0.1; // share of a shear increment along N that is an error of the axes
  std::vector<double> props_, state_;
  double separation_[3] = {0, 0, 0}, axis_[6] = {0, 0, 1, 1, 0, 0}, area_ = 0, stiffness_[2] = {0, 0};

  void check() {
    char message[4000] = "";
    if (asperity_stiffness(props_.data(), int(props_.size()), stiffness_, message, sizeof message) != ASPERITY_OK)
      throw std::runtime_error(std::string("asperity: ") + message);
  }

public:
  Text getName() const { return text("asperity"); }
  Text getPluginName() const { return getName(); }
  Text getFullName() const { return text("Asperity"); }
  Number getMinorVersion() const { return 1; }
  Text getStates() const { return text("slip-n,tension-n,slip-p,tension-p"); }
  Asperity *clone() const { return new Asperity(); }
  double getMaxNormalStiffness() const { return stiffness_[0]; }
  double getMaxShearStiffness() const { return stiffness_[1]; }

  Text getProperties() const {
    std::string names;
    for (unsigned i = 1; i <= constants; i++) names += "p" + std::to_string(i) + ",";
    return text(names + "n-x,n-y,n-z,t-x,t-y,t-z,damage,stored,rupture,friction");
  }
  Value getProperty(Number index) const {
    const unsigned i = unsigned(index) - 1;
    if (i < constants) return Value(i < props_.size() ? props_[i] : 0.0);
    if (i < constants + axes) return Value(axis_[i - constants]);
    return Value(i < constants + axes + shown && !state_.empty() ? state_[i - constants - axes] : 0.0);
  }
  void setProperty(Number index, const Value &value, Number version = 0) {
    JointModel::setProperty(index, value, version);
    const unsigned i = unsigned(index) - 1;
    const double x = number(value, 0);
    if (i < constants && (i < props_.size() || x != 0.0)) {
      props_.resize(std::max<size_t>(props_.size(), i + 1));
      props_[i] = x;
    } else if (i >= constants && i < constants + axes) {
      axis_[i - constants] = x;
    }
  }
  void copy(const JointModel *other) {
    JointModel::copy(other);
    const Asperity *from = dynamic_cast<const Asperity *>(other);
    if (from == nullptr) throw std::runtime_error("asperity: copy of another joint model");
    props_ = from->props_, state_ = from->state_, area_ = from->area_;
    std::copy(from->separation_, from->separation_ + 3, separation_);
    std::copy(from->axis_, from->axis_ + 6, axis_);
    std::copy(from->stiffness_, from->stiffness_ + 2, stiffness_);
  }
  void save(std::ostream &out) const {
    JointModel::save(out);
    const unsigned n = unsigned(state_.size());
    out.write(reinterpret_cast<const char *>(&n), sizeof n);
    out.write(reinterpret_cast<const char *>(state_.data()), std::streamsize(n * sizeof(double)));
    out.write(reinterpret_cast<const char *>(separation_), sizeof separation_);
  }
  void restore(std::istream &in, Number version) {
    JointModel::restore(in, version);
    unsigned n = 0;
    in.read(reinterpret_cast<char *>(&n), sizeof n);
    state_.resize(n);
    in.read(reinterpret_cast<char *>(state_.data()), std::streamsize(n * sizeof(double)));
    in.read(reinterpret_cast<char *>(separation_), sizeof separation_);
  }
  void initialize(Dimension dimension, State *s) {
    JointModel::initialize(dimension, s);
    check();
  }

  void run(Dimension dimension, State *s) {
    JointModel::run(dimension, s);
    const double *n = axis_, *t = axis_ + 3;
    const double across[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]};
    const double *axis[3] = {n, t, across};
    const auto along = [&](const Vector &v, int j) {
      return axis[j][0] * v.x() + axis[j][1] * v.y() + axis[j][2] * v.z();
    };
    double at[3], traction[3];
    char message[4000] = "";
    const int n_props = int(props_.size());
    area_ = s->area_;
    if (!(area_ > 0.0)) throw std::runtime_error("asperity: area " + std::to_string(area_) + ": expected > 0");
    if (std::fabs(along(s->shear_disp_inc_, 0)) > out_of_plane * s->shear_disp_inc_.mag())
      throw std::runtime_error("asperity: a shear displacement along N: expected n-x to t-z, N and Tx of this joint, "
                               "in the axes of the shear vectors");
    if (state_.empty()) {
      state_.assign(size_t(asperity_nstatv(props_.data(), n_props, message, sizeof message)), 0.0);
      if (state_.empty()) throw std::runtime_error(std::string("asperity: ") + message);
      traction[0] = -s->normal_force_ / area_;
      for (int j = 1; j < 3; j++) traction[j] = -along(s->shear_force_, j) / area_;
      if (traction[0] != 0.0 || traction[1] != 0.0 || traction[2] != 0.0)
        if (asperity_initial_state(props_.data(), n_props, 1, traction, int(state_.size()), state_.data(), message,
                                   sizeof message) != ASPERITY_OK)
          throw std::runtime_error(std::string("asperity: initial forces: ") + message);
    }
    at[0] = separation_[0] + s->normal_disp_inc_;
    for (int j = 1; j < 3; j++) at[j] = separation_[j] + along(s->shear_disp_inc_, j);
    if (asperity_update(props_.data(), n_props, s->getTimeStep(), 1, separation_, at, nullptr, nullptr,
                        int(state_.size()), state_.data(), traction, nullptr, message, sizeof message) != ASPERITY_OK)
      throw std::runtime_error(std::string("asperity: ") + message);
    std::copy(at, at + 3, separation_);
    const double normal = -area_ * traction[0];
    double shear[3];
    for (int i = 0; i < 3; i++) shear[i] = -area_ * (traction[1] * t[i] + traction[2] * across[i]);
    const Vector force(shear[0], shear[1], shear[2]);
    s->normal_force_inc_ = normal - s->normal_force_;
    s->shear_force_inc_ = force - s->shear_force_;
    s->normal_force_ = normal;
    s->shear_force_ = force;
    s->dnop_ = s->normal_disp_inc_;
  }

  // energies of the subcontact: stored, and what rupture and friction have taken
  Text getEnergies() const { return text("energy-stored,energy-rupture,energy-friction"); }
  double getEnergy(Number index) const {
    return index >= 1 && index <= 3 && !state_.empty() ? area_ * state_[index] : 0.0;
  }
  bool getEnergyActivated() const { return true; }
};

} // namespace jmodels

EXPORTED const char *getName() { return "jmodelasperity"; }
EXPORTED unsigned getMajorVersion() { return 1; }
EXPORTED unsigned getMinorVersion() { return 1; }
EXPORTED void *createInstance() { return static_cast<jmodels::JointModel *>(new jmodels::Asperity()); }
