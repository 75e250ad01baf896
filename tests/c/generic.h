/* Behaviours of libasperity_generic, as MGIS reads their symbols and calls their functions. */
#ifndef GENERIC_H
#define GENERIC_H
#include <math.h>
#include <string.h>

#include "asperity.h"
#include "check.h"
#include "libraries.h"

enum {
  MOST_PLANES = 33,
  FACET_STATEV = 2,
  CAP_STATEV = 2,
  MOST_STATEV = POINT_STATEV + (PLANE_STATEV + FACET_STATEV) * MOST_PLANES + CAP_STATEV,
  MOST_PROPERTIES = 32
};
enum { SIGMA0 = 3, RUPTURE = 2, FRICTION = 3, STORED = 1, ALPHA = POINT_STATEV };
static const double GC = 0.3, ETA = 0.9, MU = 0.5, THICKNESS = 0.25, R = 0.125;
#define S0 ((1.0 - ETA) * 2.0 * GC / SIGMA0)
#define K (SIGMA0 / S0)
/* A few roundings of numbers of the size of the strength, of the stiffness. */
#define STRESS_TOLERANCE (64 * 2.3e-16 * SIGMA0)
#define TANGENT_TOLERANCE (64 * 2.3e-16 * K)

/* Opened by open_library. */
static void *library;

typedef struct {
  double *gradients, *forces, *mass_density, *properties, *variables, *stored, *dissipated, *external_variables;
} View;

typedef struct {
  char *message;
  double dt, *tangent, *factor, *speed_of_sound;
  View old, new;
} Data;

typedef int (*Function)(Data *);
static inline const void *look(const char *behaviour, const char *what) {
  char name[128];
  snprintf(name, sizeof name, "%s_%s", behaviour, what);
  return dlsym(library, name);
}

static inline int has(const char *behaviour, const char *what) { return look(behaviour, what) != NULL; }

/* Address of a symbol of a behaviour; one that is missing is named. */
static inline const void *symbol(const char *behaviour, const char *what) {
  if (!has(behaviour, what)) fprintf(stderr, "symbol %s_%s is missing\n", behaviour, what);
  return look(behaviour, what);
}

static inline int number(const char *behaviour, const char *what) {
  const unsigned short *value = symbol(behaviour, what);
  return value == NULL ? -1 : *value;
}

static inline Function function(const char *behaviour, const char *hypothesis) {
  const void *address = symbol(behaviour, hypothesis);
  Function found;
  memcpy(&found, &address, sizeof found);
  return found;
}

typedef struct {
  double old_gradient[6], gradient[6], old_force[6], force[6], properties[MOST_PROPERTIES];
  double old_variables[MOST_STATEV], variables[MOST_STATEV], stored, dissipated, tangent[36], factor;
  double old_water, water; /* pressure, of wet behaviours */
  char message[512];
} Point;

/* Set a material property by its name, as an input file does; a name that the behaviour lacks is reported. */
static inline void set(Point *p, const char *behaviour, const char *name, double value) {
  const char *const *names = symbol(behaviour, "MaterialProperties");
  for (int i = 0; i < number(behaviour, "nMaterialProperties"); i++)
    if (strcmp(names[i], name) == 0) {
      p->properties[i] = value;
      return;
    }
  fprintf(stderr, "%s: material property %s is missing\n", behaviour, name);
}

/* A virgin point of a pattern of two sides of 30 degrees (3 planes), kc = 1, and h, r in a layer. */
static inline Point virgin(const char *behaviour) {
  Point p;
  memset(&p, 0, sizeof p);
  set(&p, behaviour, "sigma0", SIGMA0);
  set(&p, behaviour, "Gc", GC);
  set(&p, behaviour, "eta", ETA);
  set(&p, behaviour, "mu", MU);
  set(&p, behaviour, "theta", 30.0);
  set(&p, behaviour, "m", 2.0);
  set(&p, behaviour, "flat", 1.0 / 3.0);
  set(&p, behaviour, "kc", 1.0);
  if (strstr(behaviour, "Layer") != NULL) {
    set(&p, behaviour, "h", THICKNESS);
    set(&p, behaviour, "r", R);
  }
  p.factor = 1.0;
  return p;
}

static inline int call(Point *p, const char *behaviour, const char *hypothesis, double request) {
  Data d = {p->message,
            0.0,
            p->tangent,
            &p->factor,
            NULL,
            {p->old_gradient, p->old_force, NULL, p->properties, p->old_variables, NULL, NULL, &p->old_water},
            {p->gradient, p->force, NULL, p->properties, p->variables, &p->stored, &p->dissipated, &p->water}};
  p->tangent[0] = request;
  return function(behaviour, hypothesis)(&d);
}

static inline void accept(Point *p) {
  memcpy(p->old_gradient, p->gradient, sizeof p->gradient);
  memcpy(p->old_force, p->force, sizeof p->force);
  memcpy(p->old_variables, p->variables, sizeof p->variables);
  p->old_water = p->water;
}

/* Open the library that the command line names; 0 with a message where that fails. */
static inline int open_library(int count, char **arguments) {
  library = count == 2 ? dlopen(arguments[1], RTLD_NOW) : NULL;
  if (library == NULL) fprintf(stderr, "%s\n", count == 2 ? dlerror() : "expected the path of libasperity_generic");
  return library != NULL;
}

#endif
