/* libasperity_generic in a C program that reads its symbols and calls its functions as MGIS does: test_generic FILE. */
#define _POSIX_C_SOURCE 200809L
#include "generic.h"

/* The library has a C API of its own, so that the program is not linked with libasperity. */
static __typeof__(&asperity_update) update;

static const double PROPS[] = {3.0, 0.3, 0.9, 0.5, 30.0, 2.0, 1.0 / 3.0};
enum { N_PROPS = 7, N_STATEV = POINT_STATEV + PLANE_STATEV * 3, N_WORN = N_STATEV + FACET_STATEV * 3 };
enum { PLAIN, WORN_FACETS, YIELDING }; /* what a joint has beside the paper */
/* The same with asperities that end, wear and are crushed. */
static const double WORN[] = {3.0, 0.3, 0.9, 0.5, 30.0, 2.0, 1.0 / 3.0, 0.0, 1.0, 0.0, 0.0,
                              0.0, 0.0, 0.0, 0.0, 1.0,  0.0, 0.3,       2.0, 0.0, 0.0, 4.0};
/* The same with a compressive strength. */
static const double CRUSHED[] = {3.0, 0.3, 0.9, 0.5, 30.0, 2.0, 1.0 / 3.0, 0.0, 1.0, 0.0, 0.0, 0.0,  0.0, 0.0,  0.0,
                                 1.0, 0.0, 0.0, 0.0, 0.0,  0.0, 0.0,       0.0, 0.0, 0.0, 0.9, 0.05, 1.0, 0.01, 0.2};

/* All symbols that MGIS reads when it loads a behaviour. */
static int loads(const char *behaviour, int layer, int planes) {
  static const char *const numbers[] = {"mfront_mkt",
                                        "api_version",
                                        "SymmetryType",
                                        "ElasticSymmetryType",
                                        "requiresStiffnessTensor",
                                        "requiresThermalExpansionCoefficientTensor",
                                        "ComputesInternalEnergy",
                                        "ComputesDissipatedEnergy",
                                        "TemperatureRemovedFromExternalStateVariables",
                                        "nInitializeFunctions",
                                        "nPostProcessings",
                                        "nExternalStateVariables",
                                        "nParameters",
                                        "nGradients",
                                        "nThermodynamicForces",
                                        "nTangentOperatorBlocks"};
  static const int expected[] = {1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 1, 2};
  const char *gradient = layer ? "Strain" : "OpeningDisplacement", *force = layer ? "Stress" : "CohesiveForce";
  const int type = layer ? 1 : 2, n_planes_statev = POINT_STATEV + (PLANE_STATEV + FACET_STATEV) * planes,
            n_statev = n_planes_statev + CAP_STATEV;
  char last[16];
  int bad = 0;
  snprintf(last, sizeof last, "wear_work_%d", planes);
  for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
    bad += FAILS(number(behaviour, numbers[i]) == expected[i]);
  bad += FAILS(number(behaviour, "BehaviourType") == (layer ? 1 : 3));
  bad += FAILS(number(behaviour, "BehaviourKinematic") == (layer ? 1 : 2));
  const char *const *gradients = symbol(behaviour, "Gradients");
  const char *const *forces = symbol(behaviour, "ThermodynamicForces");
  const char *const *blocks = symbol(behaviour, "TangentOperatorBlocks");
  const int *kind = symbol(behaviour, "GradientsTypes"), *kinds = symbol(behaviour, "ThermodynamicForcesTypes");
  if (gradients == NULL || forces == NULL || blocks == NULL || kind == NULL || kinds == NULL) return bad + 1;
  bad += FAILS(strcmp(gradients[0], gradient) == 0 && strcmp(forces[0], force) == 0);
  bad += FAILS(strcmp(blocks[0], force) == 0 && strcmp(blocks[1], gradient) == 0);
  bad += FAILS(kind[0] == type && kinds[0] == type);
  bad += FAILS(symbol(behaviour, "ParametersTypes") != NULL);
  bad += FAILS(number(behaviour, "nInternalStateVariables") == n_statev);
  const char *const *variables = symbol(behaviour, "InternalStateVariables");
  const int *types = symbol(behaviour, "InternalStateVariablesTypes");
  if (variables == NULL || types == NULL) return bad + 1;
  bad += FAILS(strcmp(variables[0], "damage") == 0 && strcmp(variables[ALPHA], "alpha_1") == 0);
  bad += FAILS(strcmp(variables[n_planes_statev - 1], last) == 0);
  bad += FAILS(strcmp(variables[n_statev - 2], "kappa") == 0 && strcmp(variables[n_statev - 1], "crushing") == 0);
  for (int i = 0; i < n_statev; i++) bad += FAILS(types[i] == 0);
  const int n_properties = number(behaviour, "nMaterialProperties");
  bad += FAILS(n_properties > 10 && n_properties < MOST_PROPERTIES);
  const char *const *texts = symbol(behaviour, "mfront_interface");
  bad += FAILS(texts != NULL && strcmp(*texts, "Generic") == 0);
  const int n_hypotheses = number(behaviour, "nModellingHypotheses");
  const char *const *hypotheses = symbol(behaviour, "ModellingHypotheses");
  bad += FAILS(n_hypotheses == (layer ? 4 : 5));
  for (int i = 0; i < n_hypotheses; i++) bad += FAILS(has(behaviour, hypotheses[i]));
  return bad + FAILS(has(behaviour, "PlaneStress") == !layer);
}

static int every_behaviour_loads(void) {
  char name[32];
  int bad = 0;
  for (int planes = 1; planes <= MOST_PLANES; planes++)
    for (int layer = 0; layer < 2; layer++) {
      snprintf(name, sizeof name, layer ? "AsperityLayer%d" : "AsperityJoint%d", planes);
      bad += loads(name, layer, planes);
    }
  return bad + FAILS(!has("AsperityJoint34", "api_version")) + FAILS(!has("AsperityLayer0", "api_version"));
}

static int properties_are_those_of_the_contract(void) {
  /* A layer has a thickness and the stiffness of its other components; neither has the order of the components. */
  static const char *const bounds[] = {"sigma0_LowerPhysicalBound", "mu_LowerPhysicalBound", "mu_UpperPhysicalBound"};
  static const long double expected[] = {1e-50, 0.0, 1e10};
  const int n_joint = number("AsperityJoint3", "nMaterialProperties");
  int bad = FAILS(number("AsperityLayer3", "nMaterialProperties") == n_joint + 2);
  const char *const *layer = symbol("AsperityLayer3", "MaterialProperties");
  bad += FAILS(strcmp(layer[0], "sigma0") == 0 && strcmp(layer[3], "mu") == 0);
  for (int i = 0; i < number("AsperityLayer3", "nMaterialProperties"); i++)
    bad += FAILS(strcmp(layer[i], "map") != 0 && strcmp(layer[i], "reserved") != 0);
  for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
    const long double *bound = symbol("AsperityLayer3", bounds[i]);
    bad += bound == NULL ? 1 : FAILS(*bound == expected[i]);
  }
  bad += FAILS(!has("AsperityLayer3", "turn_LowerPhysicalBound"));
  return bad + FAILS(!has("AsperityJoint3", "h_UpperPhysicalBound"));
}

/* Separations: closing, sliding, back, opening. */
static const double PATH[][3] = {{-0.01, 0.02, 0.0}, {-0.02, 0.1, 0.03}, {-0.01, -0.05, 0.0}, {0.04, 0.1, -0.05}};
enum { N_PATH = sizeof PATH / sizeof *PATH };

/* The difference between n components of a behaviour and the C API along a path, to the rounding of another kernel. A
   layer passes strains s_N/h, s_Tx/(sqrt(2) h), s_Ty/(sqrt(2) h) as 11, 12, 13; its other components are elastic. In 2D
   there is no Ty. */
static int follows(const char *behaviour, int n, int kind) {
  const int worn = kind == WORN_FACETS, yields = kind == YIELDING;
  const int layer = strstr(behaviour, "Layer") != NULL, flat = n == (layer ? 4 : 2), shown = flat ? 2 : 3;
  const int at[3] = {0, layer ? 3 : 1, layer ? 4 : 2};
  const double root = layer ? sqrt(2.0) : 1.0, weight[3] = {1.0, root, root}, beside[6] = {0, 2e-3, -1e-3, 0, 0, 4e-3};
  const double h = layer ? THICKNESS : 1.0, side = R * K * h, *props = yields ? CRUSHED : worn ? WORN : PROPS;
  const int n_props = yields ? (int)(sizeof CRUSHED / sizeof *CRUSHED)
                      : worn ? (int)(sizeof WORN / sizeof *WORN)
                             : N_PROPS;
  const int n_planes_statev = worn ? N_WORN : N_STATEV, n_statev = n_planes_statev + (yields ? CAP_STATEV : 0);
  int bad = 0;
  Point p = virgin(behaviour);
  if (worn) {
    set(&p, behaviour, "height", 0.3);
    set(&p, behaviour, "W0", 2.0);
    set(&p, behaviour, "crush", 4.0);
  }
  if (yields) {
    static const char *const names[] = {"fc", "Gfc", "Css", "kp", "fcr"};
    for (int i = 0; i < 5; i++) set(&p, behaviour, names[i], CRUSHED[25 + i]);
  }
  double state[N_WORN + CAP_STATEV] = {0}, traction[3], tangent[3][3], from[3] = {0};
  for (int step = 0; step < N_PATH; step++) {
    const double s[3] = {PATH[step][0], PATH[step][1], flat ? 0.0 : PATH[step][2]};
    int component[6] = {-1, -1, -1, -1, -1, -1};
    for (int c = 0; c < shown; c++) component[at[c]] = c;
    for (int i = 0; i < n; i++)
      p.gradient[i] = component[i] < 0 ? beside[i] : s[component[i]] / (h * weight[component[i]]);
    bad += FAILS(call(&p, behaviour, !flat ? "Tridimensional" : layer ? "PlaneStrain" : "PlaneStress", 4.0) == 1);
    bad += FAILS(update(props, n_props, 0.0, 1, from, s, NULL, NULL, n_statev, state, traction, tangent[0], NULL, 0) ==
                 ASPERITY_OK);
    double elastic = 0.0;
    for (int i = 0; i < n; i++) {
      const int c = component[i];
      if (c < 0) elastic += 0.5 * side * p.gradient[i] * p.gradient[i];
      bad += DIFFERS(c < 0 ? side * p.gradient[i] : weight[c] * traction[c], p.force[i], STRESS_TOLERANCE);
      for (int j = 0; j < n; j++) {
        const int d = component[j];
        const double expected = c < 0 || d < 0 ? (i == j ? side : 0.0) : h * weight[c] * weight[d] * tangent[c][d];
        bad += DIFFERS(expected, p.tangent[n * i + j], 2 * TANGENT_TOLERANCE);
      }
    }
    for (int i = 0; i < n_statev; i++)
      bad += DIFFERS(state[i], p.variables[i < n_planes_statev ? i : N_WORN + i - n_planes_statev], 64 * 2.3e-16);
    bad += DIFFERS(state[STORED] / h + elastic, p.stored, 64 * 2.3e-16 / h);
    const double crushing = yields ? state[n_statev - 1] : 0.0;
    bad += DIFFERS((state[RUPTURE] + state[FRICTION] + crushing) / h, p.dissipated, 64 * 2.3e-16 / h);
    memcpy(from, s, sizeof from);
    accept(&p);
  }
  bad += FAILS(p.variables[FRICTION] > 0.0 && p.variables[RUPTURE] > 0.0);
  bad += FAILS(!yields || (p.variables[N_WORN] > 0.0 && p.variables[N_WORN + 1] > 0.0 && p.variables[N_STATEV] == 0.0));
  return bad + FAILS(!worn || p.variables[n_statev - 1] > 0.0);
}

static int behaviours_are_the_law(void) {
  return follows("AsperityJoint3", 3, YIELDING) + follows("AsperityLayer3", 4, YIELDING) +
         follows("AsperityJoint3", 2, 0) + follows("AsperityJoint3", 3, 0) + follows("AsperityJoint3", 3, 1) +
         follows("AsperityLayer3", 4, 0) + follows("AsperityLayer3", 6, 0) + follows("AsperityLayer3", 6, 1);
}

/* K[0]: prediction writes K alone, no operator leaves K, the elastic operator is that of the virgin joint. */
static int requests(void) {
  Point p = virgin("AsperityJoint3");
  p.gradient[1] = 0.1;
  int bad = FAILS(call(&p, "AsperityJoint3", "Tridimensional", 4.0) == 1);
  accept(&p);
  p.gradient[1] = 0.05;
  Point consistent = p, other = p;
  bad += FAILS(call(&consistent, "AsperityJoint3", "Tridimensional", 4.0) == 1);
  for (double request = 0.0; request < 4.0; request++) {
    other = p;
    for (int i = 0; i < 9; i++) other.tangent[i] = -7.0;
    bad += FAILS(call(&other, "AsperityJoint3", "Tridimensional", request) == 1);
    bad += FAILS(memcmp(other.force, consistent.force, sizeof other.force) == 0);
    for (int i = 0; i < 9; i++) {
      const double elastic = i % 4 == 0 ? K : 0.0;
      const double expected = request == 0.0 ? (i ? -7.0 : 0.0) : request == 1.0 ? elastic : consistent.tangent[i];
      bad += DIFFERS(expected, other.tangent[i], TANGENT_TOLERANCE);
    }
  }
  /* at the start: the increment to the separation of the start itself */
  Point rest = p;
  memcpy(rest.gradient, p.old_gradient, sizeof rest.gradient);
  bad += FAILS(call(&rest, "AsperityJoint3", "Tridimensional", 4.0) == 1);
  for (double request = -3.0; request < 0.0; request++) {
    other = p;
    bad += FAILS(call(&other, "AsperityJoint3", "Tridimensional", request) == 1);
    for (int i = 0; i < 9; i++)
      bad += DIFFERS(request > -1.5 ? (i % 4 == 0 ? K : 0.0) : rest.tangent[i], other.tangent[i], TANGENT_TOLERANCE);
    memcpy(other.tangent, p.tangent, sizeof p.tangent);
    bad += FAILS(memcmp(&other, &p, sizeof p) == 0);
  }
  return bad;
}

/* The call returns -1, names the culprit, and writes nothing else but the factor of the time step. */
static int rejected(Point p, const char *behaviour, double request, const char *culprit) {
  Point before = p;
  int bad = FAILS(call(&p, behaviour, "Tridimensional", request) == -1) + FAILS(p.factor == 0.25);
  if (strstr(p.message, culprit) == NULL) {
    fprintf(stderr, "message: %s\nexpected in it: %s\n", p.message, culprit);
    bad++;
  }
  bad += FAILS(strncmp(p.message, behaviour, strlen(behaviour)) == 0);
  bad += FAILS(memcmp(p.tangent, &request, sizeof request) == 0);
  memcpy(p.message, before.message, sizeof p.message);
  p.tangent[0] = before.tangent[0];
  p.factor = before.factor;
  return bad + FAILS(memcmp(&p, &before, sizeof p) == 0);
}

static int errors(void) {
  const Point good = virgin("AsperityLayer3");
  Point p = good;
  set(&p, "AsperityLayer3", "mu", -0.5);
  int bad = rejected(p, "AsperityLayer3", 4.0, "mu = -0.5: expected >= 0");
  p = good;
  set(&p, "AsperityLayer3", "m", 4.0);
  bad += rejected(p, "AsperityLayer3", 4.0, "expected AsperityLayer5 for the 5 planes (35 state variables)");
  bad += rejected(good, "AsperityLayer5", 4.0, "expected AsperityLayer3 for the 3 planes");
  set(&p, "AsperityLayer3", "m", 64.0);
  bad += rejected(p, "AsperityLayer3", 4.0, "no behaviour has those of the 65 planes (335 state variables)");
  set(&p, "AsperityLayer3", "m", -1.0);
  bad += rejected(p, "AsperityLayer3", 4.0, "m = -1: expected a regular pattern");
  p = good;
  p.gradient[0] = NAN;
  bad += rejected(p, "AsperityLayer3", 4.0, "gradient 1 = NaN");
  p = good;
  p.gradient[1] = HUGE_VAL; /* a component that an interface does not have */
  bad += rejected(p, "AsperityLayer3", 0.0, "gradient 2 = Inf");
  p = good;
  bad += rejected(good, "AsperityLayer3", NAN, "K[0] = NaN");
  set(&p, "AsperityLayer3", "m", NAN);
  bad += rejected(p, "AsperityLayer3", 4.0, "m = NaN");
  p = good;
  p.old_variables[ALPHA] = 1.5;
  bad += rejected(p, "AsperityLayer3", 4.0, "alpha = 1.5");
  bad += rejected(p, "AsperityLayer3", -1.0, "alpha = 1.5");
  bad += rejected(good, "AsperityLayer3", 104.0, "K[0] = 104");
  p = good;
  p.old_force[0] = 10.0 * SIGMA0;
  bad += rejected(p, "AsperityLayer3", 4.0, "t_N");
  /* without a buffer for the message and without a factor */
  Data d = {NULL,
            0.0,
            p.tangent,
            NULL,
            NULL,
            {p.old_gradient, p.old_force, NULL, p.properties, p.old_variables, NULL, NULL, NULL},
            {p.gradient, p.force, NULL, p.properties, p.variables, NULL, NULL, NULL}};
  p.tangent[0] = 4.0;
  bad += FAILS(function("AsperityLayer3", "Tridimensional")(&d) == -1);
  p.old_force[0] = 0.0;
  return bad + FAILS(function("AsperityLayer3", "Tridimensional")(&d) == 1);
}

static int time_and_its_step(void) {
  /* Viscous damage needs a duration. Damage that grows by more than dalpha asks for a smaller step, with results. */
  Point p = virgin("AsperityJoint3");
  set(&p, "AsperityJoint3", "tau_v", 1.0);
  Data d = {p.message,
            -1.0,
            p.tangent,
            &p.factor,
            NULL,
            {p.old_gradient, p.old_force, NULL, p.properties, p.old_variables, NULL, NULL, NULL},
            {p.gradient, p.force, NULL, p.properties, p.variables, NULL, NULL, NULL}};
  int bad = FAILS(function("AsperityJoint3", "Tridimensional")(&d) == -1) + FAILS(strstr(p.message, "dt = -1") != NULL);
  p = virgin("AsperityJoint3");
  set(&p, "AsperityJoint3", "dalpha", 0.25);
  p.gradient[0] = 10.0 * S0; /* damage (1 - 1/10)/eta = 1 */
  bad += FAILS(call(&p, "AsperityJoint3", "Tridimensional", 4.0) == 1);
  bad += DIFFERS(0.25, p.factor, 4 * 2.3e-16) + DIFFERS(1.0, p.variables[ALPHA], 4 * 2.3e-16);
  return bad;
}

/* Forces at the first call, at a strain that is not zero, are the initial traction; STATEV 5 ends that. */
static int initial_traction(void) {
  Point p = virgin("AsperityLayer3");
  const double traction[3] = {-1.0, 0.25, 0.125};
  p.old_force[0] = traction[0];
  p.old_force[3] = sqrt(2.0) * traction[1];
  p.old_force[4] = sqrt(2.0) * traction[2];
  p.old_gradient[0] = p.gradient[0] = 0.5;
  int bad = FAILS(call(&p, "AsperityLayer3", "Tridimensional", 4.0) == 1);
  bad += DIFFERS(traction[0], p.force[0], 1e-9 * SIGMA0) + DIFFERS(sqrt(2.0) * traction[1], p.force[3], 1e-9 * SIGMA0);
  bad += DIFFERS(sqrt(2.0) * traction[2], p.force[4], 1e-9 * SIGMA0) + FAILS(p.variables[STATUS] == 1.0);
  accept(&p);
  p.old_force[0] = 100.0;
  bad += FAILS(call(&p, "AsperityLayer3", "Tridimensional", 4.0) == 1);
  return bad + DIFFERS(traction[0], p.force[0], 1e-9 * SIGMA0);
}

int main(int count, char **arguments) {
  static int (*const tests[])(void) = {every_behaviour_loads,
                                       properties_are_those_of_the_contract,
                                       behaviours_are_the_law,
                                       requests,
                                       errors,
                                       time_and_its_step,
                                       initial_traction};
  if (!open_library(count, arguments)) return 1;
  const void *address = dlsym(library, "asperity_update");
  memcpy(&update, &address, sizeof update);
  if (update == NULL || !has("AsperityJoint3", "MaterialProperties"))
    return check_run(1, tests); /* the other tests need the symbols */
  return check_run(sizeof tests / sizeof *tests, tests);
}
