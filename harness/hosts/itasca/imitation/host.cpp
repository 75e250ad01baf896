// What a test calls: a subcontact with its model, which is made, copied, saved and run as 3DEC does.
#include "state.h"
#include <cstring>
#include <sstream>

extern "C" void *createInstance();

namespace {
struct Here : jmodels::State {
  double step = 0;
  double getTimeStep() const { return step; }
};
struct Contact {
  jmodels::JointModel *model;
  Here state;
};
} // namespace

extern "C" {
void *contact_make(double area) {
  jmodels::JointModel *first = static_cast<jmodels::JointModel *>(createInstance());
  Contact *contact = new Contact{first->clone(), {}};
  contact->model->copy(first);
  delete first;
  contact->state.area_ = area;
  return contact;
}
void contact_set(void *contact, unsigned index, double value) {
  static_cast<Contact *>(contact)->model->setProperty(index, Content(value));
}
double contact_get(void *contact, unsigned index) {
#ifdef OLD
  return static_cast<Contact *>(contact)->model->getProperty(index).toDouble();
#else
  return static_cast<Contact *>(contact)->model->getProperty(index).to<double>();
#endif
}
double contact_energy(void *contact, unsigned index) {
  return static_cast<Contact *>(contact)->model->getEnergy(index);
}
void contact_stiffness(void *contact, double *k) {
  k[0] = static_cast<Contact *>(contact)->model->getMaxNormalStiffness();
  k[1] = static_cast<Contact *>(contact)->model->getMaxShearStiffness();
}
void contact_force(void *contact, double normal, const double *shear) {
  Here &s = static_cast<Contact *>(contact)->state;
  s.normal_force_ = normal, s.shear_force_ = DVect3(shear[0], shear[1], shear[2]);
}
/* a file of the program in the middle of a run */
void contact_restore(void *contact) {
  Contact *c = static_cast<Contact *>(contact);
  std::stringstream file;
  c->model->save(file);
  jmodels::JointModel *again = c->model->clone();
  for (unsigned i = 1; i <= 102; i++) again->setProperty(i, c->model->getProperty(i), 1);
  again->restore(file, 1);
  delete c->model;
  c->model = again;
}
int contact_run(void *contact, double dt, double normal, const double *shear, double *force, char *message, int size) {
  Contact *c = static_cast<Contact *>(contact);
  Here &s = c->state;
  s.step = dt, s.normal_disp_inc_ = normal, s.shear_disp_inc_ = DVect3(shear[0], shear[1], shear[2]);
  const double before = s.normal_force_;
  try {
    c->model->run(3, &s);
  } catch (const std::exception &error) {
    std::strncpy(message, error.what(), size - 1);
    return 1;
  }
  force[0] = s.normal_force_, force[1] = s.shear_force_.x(), force[2] = s.shear_force_.y();
  force[3] = s.shear_force_.z(), force[4] = s.normal_force_ - before - s.normal_force_inc_;
  return 0;
}
}
