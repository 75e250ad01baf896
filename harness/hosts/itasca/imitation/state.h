// Imitation of the structure that joint models of 3DEC and UDEC get: our own text.
#ifndef STATE_H
#define STATE_H
#include "jointmodel.h"

namespace jmodels {
struct State {
  virtual ~State() {}
  virtual double getTimeStep() const = 0;
  unsigned state_ = 0;
  double area_ = 1, normal_force_ = 0;
  DVect3 shear_force_;
  double normal_disp_ = 0;
  DVect3 shear_disp_;
  double normal_disp_inc_ = 0;
  DVect3 shear_disp_inc_;
  double normal_force_inc_ = 0;
  DVect3 shear_force_inc_;
  double dnop_ = 0, working_[10] = {0};
};
} // namespace jmodels
#endif
