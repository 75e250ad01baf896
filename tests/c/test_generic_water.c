/* Wet behaviours of libasperity_generic, which have an external state variable, the water pressure. */
#define _POSIX_C_SOURCE 200809L
#include "generic.h"

/* A point with the constants of `virgin`, whose damage asks for small steps and whose asperities end. */
static Point point_of(const char *behaviour) {
  Point p = virgin(behaviour);
  set(&p, behaviour, "height", 0.3);
  set(&p, behaviour, "dalpha", 0.125);
  return p;
}

/* One external state variable, a scalar; the functions and properties of the behaviour without water. */
static int loads(const char *wet, const char *dry, const char *const *hypotheses) {
  int bad = FAILS(number(wet, "nExternalStateVariables") == 1) + FAILS(number(dry, "nExternalStateVariables") == 0);
  const char *const *names = symbol(wet, "ExternalStateVariables");
  const int *types = symbol(wet, "ExternalStateVariablesTypes");
  if (names == NULL || types == NULL || symbol(dry, "ExternalStateVariablesTypes") == NULL) return bad + 1;
  bad += FAILS(strcmp(names[0], "FluidPressure") == 0 && names[1] == NULL && types[0] == 0);
  for (int i = 0; hypotheses[i] != NULL; i++) bad += FAILS(has(wet, hypotheses[i]) == has(dry, hypotheses[i]));
  const int n = number(dry, "nMaterialProperties");
  bad += FAILS(number(wet, "nMaterialProperties") == n);
  const char *const *of_wet = symbol(wet, "MaterialProperties"), *const *of_dry = symbol(dry, "MaterialProperties");
  if (of_wet == NULL || of_dry == NULL) return bad + 1;
  for (int i = 0; i < n; i++) bad += FAILS(strcmp(of_wet[i], of_dry[i]) == 0);
  bad += FAILS(number(wet, "nInternalStateVariables") == number(dry, "nInternalStateVariables"));
  return bad + FAILS(has(wet, "sigma0_LowerPhysicalBound"));
}

static int every_wet_behaviour_loads(void) {
  static const char *const of_joint[] = {"Tridimensional",         "PlaneStrain", "Axisymmetrical",
                                         "GeneralisedPlaneStrain", "PlaneStress", NULL};
  static const char *const none[] = {NULL}, *const kinds[] = {"Joint", "Layer", "Castem"};
  char dry[32], wet[32];
  int bad = 0;
  for (int planes = 1; planes <= MOST_PLANES; planes++)
    for (int kind = 0; kind < 3; kind++) {
      snprintf(dry, sizeof dry, "Asperity%s%d", kinds[kind], planes);
      snprintf(wet, sizeof wet, "AsperityWet%s%d", kinds[kind], planes);
      bad += loads(wet, dry, kind < 2 ? of_joint : none);
    }
  return bad;
}

/* Along a path the force is that of the dry behaviour less the pressure along N, and all else is the same to the last
   bit. The initial forces are total. */
static int follows(const char *wet, const char *dry, const char *hypothesis, int n, int tx) {
  static const double path[][3] = {
      {0.0, 0.0, 0.5}, {-0.01, 0.02, 0.25}, {-0.02, 0.1, 1.5}, {0.04, -0.05, 0.0}, {0.05, 0.1, 2.0}};
  Point with = point_of(wet), without = point_of(dry);
  int bad = 0;
  with.old_force[0] = -1.0;
  with.old_water = 0.75;
  without.old_force[0] = -0.25;
  for (size_t step = 0; step < sizeof path / sizeof *path; step++) {
    with.gradient[0] = without.gradient[0] = path[step][0];
    with.gradient[tx] = without.gradient[tx] = path[step][1];
    with.water = path[step][2];
    for (int request = 4; request >= -3; request--) {
      with.factor = without.factor = 1.0;
      bad += FAILS(call(&with, wet, hypothesis, request) == 1) + FAILS(call(&without, dry, hypothesis, request) == 1);
      bad += FAILS(memcmp(with.tangent, without.tangent, sizeof with.tangent) == 0);
      bad += FAILS(with.factor == without.factor);
    }
    bad += FAILS(with.force[0] == without.force[0] - with.water);
    for (int i = 1; i < n; i++) bad += FAILS(with.force[i] == without.force[i]);
    bad += FAILS(memcmp(with.variables, without.variables, sizeof with.variables) == 0);
    bad += FAILS(with.stored == without.stored && with.dissipated == without.dissipated);
    accept(&with);
    accept(&without);
  }
  return bad + FAILS(with.variables[RUPTURE] > 0.0 && with.variables[FRICTION] > 0.0);
}

static int wet_forces_are_total(void) {
  return follows("AsperityWetJoint3", "AsperityJoint3", "PlaneStrain", 2, 1) +
         follows("AsperityWetJoint3", "AsperityJoint3", "Tridimensional", 3, 1) +
         follows("AsperityWetLayer3", "AsperityLayer3", "PlaneStrain", 4, 3) +
         follows("AsperityWetLayer3", "AsperityLayer3", "Tridimensional", 6, 3);
}

/* The call returns -1, names what is wrong, and writes nothing else but the factor of the time step. */
static int rejected(Point p, const char *behaviour, const char *culprit) {
  Point before = p;
  int bad = FAILS(call(&p, behaviour, "Tridimensional", 4.0) == -1) + FAILS(p.factor == 0.25);
  if (strncmp(p.message, behaviour, strlen(behaviour)) != 0 || strstr(p.message, culprit) == NULL) {
    fprintf(stderr, "message: %s\nexpected in it: %s\n", p.message, culprit);
    bad++;
  }
  memcpy(p.message, before.message, sizeof p.message);
  p.tangent[0] = before.tangent[0];
  p.factor = before.factor;
  /* bits, as the pressure may be NaN */
  return bad + FAILS(memcmp(&p, &before, sizeof p) == 0);
}

static int errors(void) {
  static const char *const expected = ": expected the water pressure in the joint, finite and >= 0";
  static const double bad_values[] = {-1.0, -1e-300, NAN, HUGE_VAL};
  char culprit[128];
  const Point good = point_of("AsperityWetLayer3");
  int bad = 0;
  Point p;
  for (size_t i = 0; i < sizeof bad_values / sizeof *bad_values; i++) {
    p = good;
    p.water = bad_values[i];
    snprintf(culprit, sizeof culprit, " at the end%s", expected);
    bad += rejected(p, "AsperityWetLayer3", culprit);
    p = good;
    p.old_water = bad_values[i];
    snprintf(culprit, sizeof culprit, " at the start%s", expected);
    bad += rejected(p, "AsperityWetLayer3", culprit);
  }
  p = good;
  p.water = -0.5;
  bad += rejected(p, "AsperityWetLayer3", "FluidPressure = -0.5 at the end: expected the water");
  bad += rejected(good, "AsperityWetLayer5", "expected AsperityWetLayer3 for the 3 planes");
  p = good;
  p.old_force[0] = SIGMA0; /* with the water more than the bond carries */
  p.old_water = p.water = 1.0;
  bad += rejected(p, "AsperityWetLayer3", "initial t_N: that of the host and FluidPressure");
  p.old_force[0] = -1.0;
  bad += FAILS(call(&p, "AsperityWetLayer3", "Tridimensional", 4.0) == 1);
  /* without an array of external state variables */
  p = good;
  Data d = {p.message,
            0.0,
            p.tangent,
            NULL,
            NULL,
            {p.old_gradient, p.old_force, NULL, p.properties, p.old_variables, NULL, NULL, NULL},
            {p.gradient, p.force, NULL, p.properties, p.variables, NULL, NULL, NULL}};
  p.tangent[0] = 4.0;
  bad += FAILS(function("AsperityWetLayer3", "Tridimensional")(&d) == -1);
  return bad + FAILS(strstr(p.message, "FluidPressure = NaN at the start") != NULL);
}

int main(int count, char **arguments) {
  static int (*const tests[])(void) = {every_wet_behaviour_loads, wet_forces_are_total, errors};
  if (!open_library(count, arguments)) return 1;
  if (!has("AsperityWetJoint3", "MaterialProperties")) return check_run(1, tests); /* the others need the symbols */
  return check_run(sizeof tests / sizeof *tests, tests);
}
