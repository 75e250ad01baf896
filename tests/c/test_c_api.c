/* The C API in a C program: texts, sizes, layout of arrays; tests/python has numbers (test_oracle.py) and refusals. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "asperity.h"
#include "check.h"

/* Parameters of the paper's Table 2, (12): s0 = (1 - eta) 2 Gc/sigma0, K = sigma0/s0. */
enum { SIGMA0 = 3, FLAT_STATEV = POINT_STATEV + PLANE_STATEV, ALPHA = POINT_STATEV };
static const double GC = 0.3, ETA = 0.9, MU = 0.5;
#define S0 ((1.0 - ETA) * 2.0 * GC / SIGMA0)
#define K (SIGMA0 / S0)
#define FLAT_PROPS {SIGMA0, GC, ETA, MU}
enum { N_FLAT_PROPS = 4 };

/* The tolerance is a few roundings of numbers of the size of the strength. */
static const double STRESS_TOLERANCE = 16 * 2.3e-16 * SIGMA0;
#define TANGENT_TOLERANCE (16 * 2.3e-16 * K)

static int version_is_text(void) {
  char text[] = "####################", cut[] = "######";
  int length = asperity_version(text, sizeof text);
  int bad = FAILS(length == (int)strlen(text)) + FAILS(strcmp(text, ASPERITY_EXPECTED_VERSION) == 0);
  bad += FAILS(asperity_version(cut, 3) == length) + FAILS(strlen(cut) == 2 && strncmp(cut, text, 2) == 0);
  bad += FAILS(cut[3] == '#');
  return bad + FAILS(asperity_version(NULL, 0) == length);
}

static int kernels_are_those_of_the_environment(void) {
  /* tests/c/CMakeLists.txt runs this program a second time with ASPERITY_ISA=v1 */
  const char *wanted = getenv("ASPERITY_ISA");
  int isa = asperity_isa();
  return FAILS(isa == 0 || isa == 1 || isa == 3) + FAILS(!wanted || isa <= 1);
}

static int nstatv_counts_planes(void) {
  /* The contract gives 8 + 3 Np, with m inclined planes and, by the default share, the flat one. */
  const double regular[] = {SIGMA0, GC, ETA, MU, 30.0, 4.0}, flat[] = FLAT_PROPS;
  char message[] = "######";
  int bad = FAILS(asperity_nstatv(regular, 6, message, sizeof message) == POINT_STATEV + PLANE_STATEV * (4 + 1)) +
            FAILS(message[0] == '\0');
  return bad + FAILS(asperity_nstatv(flat, N_FLAT_PROPS, NULL, 0) == FLAT_STATEV);
}

static int bad_props_are_named_all_at_once(void) {
  const double props[] = {-1.0, GC, 2.0, MU};
  char message[512], tiny[] = "########";
  int bad = FAILS(asperity_nstatv(props, 4, message, sizeof message) == 0);
  bad += FAILS(strstr(message, "sigma0") != NULL) + FAILS(strstr(message, "eta") != NULL);
  bad += FAILS(asperity_nstatv(props, 4, tiny, 8) == 0);
  return bad + FAILS(strlen(tiny) == 7 && strncmp(tiny, message, strlen(tiny)) == 0);
}

static int tangent_comes_by_rows(void) {
  /* The fully damaged flat plane slides in contact: t_N = K s_N, t_Tx = -mu K s_N. Only row Tx depends on s_N. */
  const double props[] = FLAT_PROPS;
  const double s[3] = {-0.1 * S0, 10.0 * S0, 0.0};
  double state[FLAT_STATEV] = {0}, traction[3], tangent[3][3];
  state[ALPHA] = 1.0;
  int bad = FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, NULL, s, NULL, NULL, FLAT_STATEV, state, traction,
                                  tangent[0], NULL, 0) == ASPERITY_OK);
  bad += DIFFERS(K * s[0], traction[0], STRESS_TOLERANCE) + DIFFERS(-MU * K * s[0], traction[1], STRESS_TOLERANCE);
  return bad + DIFFERS(-MU * K, tangent[1][0], TANGENT_TOLERANCE) + DIFFERS(0.0, tangent[0][1], TANGENT_TOLERANCE);
}

static int friction_keeps_the_bound_of_the_aim(void) {
  /* Flat fully damaged plane: the pressure is that of s, the friction strength that of the aim. */
  const double props[] = FLAT_PROPS, s[3] = {-0.2 * S0, 10.0 * S0, 0.0};
  double aim[3] = {-0.1 * S0, 0.0, S0}, state[FLAT_STATEV] = {0}, traction[3], tangent[3][3];
  char message[256];
  state[ALPHA] = 1.0;
  int bad = FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, NULL, s, aim, NULL, FLAT_STATEV, state, traction,
                                  tangent[0], NULL, 0) == ASPERITY_OK);
  bad += DIFFERS(K * s[0], traction[0], STRESS_TOLERANCE) + DIFFERS(-MU * K * aim[0], traction[1], STRESS_TOLERANCE);
  bad += DIFFERS(0.0, tangent[1][0], TANGENT_TOLERANCE) + DIFFERS(K, tangent[0][0], TANGENT_TOLERANCE);
  /* the state is that of s */
  bad += DIFFERS(s[1] + MU * s[0], state[ALPHA + 1], 1e-12 * s[1]);
  aim[0] = nan("");
  bad += FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, NULL, s, aim, NULL, FLAT_STATEV, state, traction, NULL,
                               message, sizeof message) == ASPERITY_BAD_SEPARATION);
  return bad + FAILS(strstr(message, "s_N of the aim = NaN") != NULL);
}

static int null_start_and_null_tangent(void) {
  const double props[] = FLAT_PROPS, zero[3] = {0}, s[3] = {2.0 * S0, S0, -S0}, unknown[3] = {nan(""), 0.0, 0.0};
  double state[2][FLAT_STATEV] = {{0}}, traction[2][3], tangent[3][3];
  char message[256];
  int bad = FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, NULL, s, NULL, NULL, FLAT_STATEV, state[0], traction[0],
                                  NULL, NULL, 0) == ASPERITY_OK);
  bad += FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, zero, s, NULL, NULL, FLAT_STATEV, state[1], traction[1],
                               tangent[0], NULL, 0) == ASPERITY_OK);
  bad += FAILS(state[0][ALPHA] > 0.0);
  bad += FAILS(memcmp(state[0], state[1], sizeof state[0]) == 0);
  bad += FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, unknown, s, NULL, NULL, FLAT_STATEV, state[1], traction[1],
                               NULL, message, sizeof message) == ASPERITY_BAD_SEPARATION);
  bad += FAILS(strstr(message, "s_N at the start = NaN") != NULL);
  return bad + FAILS(memcmp(traction[0], traction[1], sizeof traction[0]) == 0);
}

static int null_arrays(void) {
  /* An array that is NULL is named; without points none is needed. */
  const double props[] = FLAT_PROPS, s[3] = {S0, 0.0, 0.0};
  double state[FLAT_STATEV] = {0}, traction[3];
  char message[256];
  int bad = FAILS(asperity_nstatv(NULL, N_FLAT_PROPS, message, sizeof message) == 0);
  bad += FAILS(strstr(message, "props is NULL: expected an array") != NULL);
  const char *names[] = {"props", "s", "state", "traction"};
  for (int i = 0; i < 4; i++) {
    bad += FAILS(asperity_update(i == 0 ? NULL : props, N_FLAT_PROPS, 0.0, 1, NULL, i == 1 ? NULL : s, NULL, NULL,
                                 FLAT_STATEV, i == 2 ? NULL : state, i == 3 ? NULL : traction, NULL, message,
                                 sizeof message) == ASPERITY_BAD_SIZE);
    bad += FAILS(strstr(message, names[i]) == message) + FAILS(strstr(message, " is NULL") != NULL);
    if (i == 1) continue;
    bad += FAILS(asperity_initial_state(i == 0 ? NULL : props, N_FLAT_PROPS, 1, i == 3 ? NULL : s, FLAT_STATEV,
                                        i == 2 ? NULL : state, message, sizeof message) == ASPERITY_BAD_SIZE);
    bad += FAILS(strstr(message, names[i]) == message);
  }
  bad += FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 0, NULL, NULL, NULL, NULL, FLAT_STATEV, NULL, NULL, NULL,
                               message, sizeof message) == ASPERITY_OK);
  return bad + FAILS(asperity_initial_state(props, N_FLAT_PROPS, 0, NULL, FLAT_STATEV, NULL, message, sizeof message) ==
                     ASPERITY_OK);
}

static int negative_counts_are_told_as_they_came(void) {
  const double props[] = FLAT_PROPS, zero[3] = {0};
  double state[FLAT_STATEV] = {0}, traction[3] = {-7.0, -7.0, -7.0};
  char message[256] = "";
  int bad = FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, NULL, zero, NULL, NULL, FLAT_STATEV, state, traction,
                                  NULL, message, -1) == ASPERITY_BAD_SIZE);
  bad += FAILS(traction[0] == -7.0) + FAILS(state[STATUS] == 0.0) + FAILS(message[0] == '\0');
  bad += FAILS(asperity_nstatv(props, -5, message, sizeof message) == 0);
  bad += FAILS(strstr(message, "NPROPS = -5: expected at least 4") != NULL);
  bad += FAILS(asperity_initial_state(props, N_FLAT_PROPS, 1, zero, -4, state, message, sizeof message) ==
               ASPERITY_FEW_STATEV);
  return bad + FAILS(strstr(message, "NSTATV = -4: expected at least 11") != NULL);
}

static int iterate_has_all_but_the_dissipated_energies(void) {
  /* A slip that breaks a rough joint in one increment; an iterate is no start of a further one. */
  enum { PLANES = 5, N = POINT_STATEV + PLANE_STATEV * PLANES, RUPTURE = 2, FRICTION = 3 };
  const double props[18] = {SIGMA0, GC, ETA, MU, 30.0, PLANES - 1, [15] = 20.0, [17] = 50.0 * S0};
  const double start[3] = {-0.01 * S0, 0.0, 0.0}, end[3] = {0.0, 30.0 * S0, 2.0 * S0};
  double state[2][N] = {{0}, {0}}, t[2][3], d[2][3][3];
  char message[256] = "";
  int bad = FAILS(asperity_update(props, 18, 0.0, 1, start, end, NULL, NULL, N, state[0], t[0], d[0][0], NULL, 0) ==
                  ASPERITY_OK);
  bad += FAILS(asperity_iterate(props, 18, 0.0, 1, start, end, NULL, NULL, N, state[1], t[1], d[1][0], message,
                                sizeof message) == ASPERITY_OK);
  bad += FAILS(state[0][RUPTURE] > 0.5 * GC && state[0][FRICTION] > 0.0);
  bad += FAILS(isnan(state[1][RUPTURE]) && isnan(state[1][FRICTION]));
  for (int i = 0; i < N; i++) bad += FAILS(i == RUPTURE || i == FRICTION || state[0][i] == state[1][i]);
  for (int i = 0; i < 3; i++) bad += FAILS(t[0][i] == t[1][i]);
  for (int i = 0; i < 9; i++) bad += FAILS(d[0][i / 3][i % 3] == d[1][i / 3][i % 3]);
  bad += FAILS(asperity_iterate(props, 18, 0.0, 1, end, start, NULL, NULL, N, state[1], t[1], NULL, message,
                                sizeof message) == ASPERITY_BAD_STATE);
  return bad + FAILS(strstr(message, "STATEV(3) rupture = NaN") != NULL);
}

static int initial_state_carries_the_traction(void) {
  /* A virgin flat plane: offset = traction/K. A fully damaged one has no tension. Counts are not negative. */
  const double props[] = FLAT_PROPS, zero[3] = {0.0, 0.0, 0.0}, wanted[3] = {-2.0 * SIGMA0, 0.2 * SIGMA0, 0.0};
  const double tension[2][3] = {{0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}}, bad_props[] = {-1.0, GC, ETA, MU};
  double state[FLAT_STATEV] = {0}, dead[2][FLAT_STATEV] = {{0}, {0}}, traction[3];
  char message[512];
  int bad = FAILS(asperity_initial_state(props, N_FLAT_PROPS, 1, wanted, FLAT_STATEV, state, message, sizeof message) ==
                  ASPERITY_OK);
  for (int i = 0; i < 3; i++) bad += DIFFERS(wanted[i] / K, state[OFFSET + i], 1e-10 * S0);
  bad += FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 1, NULL, zero, NULL, NULL, FLAT_STATEV, state, traction, NULL,
                               NULL, 0) == ASPERITY_OK);
  for (int i = 0; i < 3; i++) bad += DIFFERS(wanted[i], traction[i], 1e-10 * SIGMA0);
  dead[0][ALPHA] = dead[1][ALPHA] = 1.0;
  bad += FAILS(asperity_initial_state(props, N_FLAT_PROPS, 2, tension[0], FLAT_STATEV, dead[0], message,
                                      sizeof message) == ASPERITY_BAD_INITIAL);
  bad += FAILS(strstr(message, "point 1 (of 0 to 1): initial t_N = 0.5: tension on a crack") != NULL);
  bad += FAILS(dead[1][OFFSET] == 0.0);
  bad += FAILS(asperity_initial_state(props, N_FLAT_PROPS, -1, wanted, FLAT_STATEV, state, message, sizeof message) ==
               ASPERITY_BAD_SIZE);
  return bad + FAILS(asperity_initial_state(bad_props, 4, 1, wanted, FLAT_STATEV, state, message, sizeof message) ==
                     ASPERITY_BAD_PROPS);
}

static int water_is_part_of_the_total_traction(void) {
  /* The law carries the total normal traction and the pressure; a bad pressure is named, and nothing is written. */
  const double props[] = FLAT_PROPS, s[2][3] = {{-0.1 * S0, 0.5 * S0, 0.0}, {S0, 0.0, 0.0}};
  const double p[2] = {0.25, 0.5}, bad_p[2] = {0.25, -0.5};
  double dry[2][3], wet[2][3], state[3][2][FLAT_STATEV] = {{{0.0}}};
  char message[200];
  int bad = FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 2, NULL, s[0], NULL, NULL, FLAT_STATEV, state[0][0], dry[0],
                                  NULL, NULL, 0) == ASPERITY_OK);
  bad += FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 2, NULL, s[0], NULL, p, FLAT_STATEV, state[1][0], wet[0], NULL,
                               NULL, 0) == ASPERITY_OK);
  for (int i = 0; i < 2; i++)
    bad += FAILS(wet[i][0] == dry[i][0] - p[i] && wet[i][1] == dry[i][1] && wet[i][2] == dry[i][2]);
  bad += FAILS(memcmp(state[0], state[1], sizeof state[0]) == 0);
  bad += FAILS(asperity_update(props, N_FLAT_PROPS, 0.0, 2, NULL, s[0], NULL, bad_p, FLAT_STATEV, state[2][0], wet[0],
                               NULL, message, sizeof message) == ASPERITY_BAD_WATER);
  bad += FAILS(strstr(message, "point 1 (of 0 to 1): p = -0.5: expected a finite water pressure >= 0") != NULL);
  for (int i = 0; i < FLAT_STATEV; i++) bad += FAILS(!(fabs(state[2][0][i]) > 0.0));
  return bad;
}

static int threads_of_the_host_have_their_own_points(void) {
  /* Each thread of a host's parallel region updates arrays of its own; with OpenMP in one library for both. */
  enum { MOST = 3000, THREADS = 3, SIZES = 3 };
  const double props[] = FLAT_PROPS;
  const int sizes[SIZES] = {1, 100, MOST};
  static double s[MOST][3], state[THREADS + 1][MOST][FLAT_STATEV], traction[THREADS + 1][MOST][3];
  int bad = 0;
  for (int i = 0; i < MOST; i++) s[i][1] = S0 * (1.0 + 8.0 * i / MOST);
  for (int k = 0; k < SIZES; k++) {
    int status[THREADS + 1];
    memset(state, 0, sizeof state);
    memset(traction, 0, sizeof traction);
    status[0] = asperity_update(props, N_FLAT_PROPS, 0.0, sizes[k], NULL, s[0], NULL, NULL, FLAT_STATEV, state[0][0],
                                traction[0][0], NULL, NULL, 0);
#pragma omp parallel for num_threads(THREADS) schedule(static, 1)
    for (int t = 1; t <= THREADS; t++) {
      status[t] = asperity_update(props, N_FLAT_PROPS, 0.0, sizes[k], NULL, s[0], NULL, NULL, FLAT_STATEV, state[t][0],
                                  traction[t][0], NULL, NULL, 0);
    }
    bad += FAILS(traction[0][sizes[k] - 1][1] > 0.0);
    for (int t = 0; t <= THREADS; t++) {
      bad += FAILS(status[t] == ASPERITY_OK) + FAILS(memcmp(state[t], state[0], sizeof state[0]) == 0);
      bad += FAILS(memcmp(traction[t], traction[0], sizeof traction[0]) == 0);
    }
  }
  return bad;
}

static int planes_have_the_normals_of_the_pattern(void) {
  /* m = 4 planes of 30 degrees and, by the default share, the flat one, which is the first */
  const double props[] = {SIGMA0, GC, ETA, MU, 30.0, 4.0}, bad_props[] = {-1.0, GC, ETA, MU};
  double normals[6][3], weights[6] = {0.0}, sum = 0.0;
  weights[5] = -1.0;
  int n = asperity_planes(props, 6, 6, normals[0], weights);
  int bad = FAILS(n == 5) + FAILS(weights[5] == -1.0) + FAILS(normals[0][0] == 1.0);
  for (int i = 0; i < n; i++) sum += weights[i];
  for (int i = 1; i < n; i++) bad += DIFFERS(cos(acos(-1.0) / 6.0), normals[i][0], 1e-15);
  bad += DIFFERS(1.0, sum, 1e-15) + FAILS(asperity_planes(props, 6, 0, NULL, NULL) == 5);
  return bad + FAILS(asperity_planes(bad_props, 4, 0, NULL, NULL) == 0);
}

static int warnings_are_counted(void) {
  /* kc = 1: the contact is as soft as the bond, and a pressure closes it visibly; steep planes lock with mu tan >= 1 */
  const double soft[] = {SIGMA0, GC, ETA, MU, 30.0, 4.0}, good[] = FLAT_PROPS;
  char message[1024], tiny[2] = "#";
  int bad = FAILS(asperity_warn(soft, 6, SIGMA0, 0.0, 0.0, message, sizeof message) >= 1);
  bad += FAILS(strstr(message, "the contact is soft") != NULL);
  bad += FAILS(asperity_warn(good, N_FLAT_PROPS, 0.0, 0.0, 0.0, tiny, sizeof tiny) == 0);
  bad += FAILS(tiny[0] == '\0' && message[0] != '\0');
  return bad + FAILS(asperity_slip_increment(soft, 6, 1.0, 1.0, message, sizeof message) == 0) +
         FAILS(message[0] == '\0');
}

static int stiffnesses_make_a_joint_without_bond(void) {
  /* K = sigma0/s0 is ks, and kc = kn/ks; what the caller gives for mu stays */
  double props[20] = {0.0};
  props[3] = MU;
  asperity_joint(50.0, 20.0, props, 20);
  double s0 = (1.0 - props[2]) * 2.0 * props[1] / props[0];
  int bad = DIFFERS(20.0, props[0] / s0, 1e-13 * 20.0) + FAILS(props[3] == MU);
  double cut[3] = {0.0};
  asperity_joint(50.0, 20.0, cut, 3);
  return bad + FAILS(memcmp(cut, props, sizeof cut) == 0);
}

/* Increments by columns are separations by rows, with a column of the state that is longer than the block. */
static int blocks_by_columns_are_points(void) {
  enum { N = 3, STRIDE = 5, STATES = POINT_STATEV + 3 * PLANE_STATEV };
  const double props[] = {3.0, 0.3, 0.9, 0.5, 30.0, 2.0, 1.0 / 3.0, 0.0, 0.1}; /* h has no effect */
  double at[N][3] = {{0}}, end[N][3], state[N][STATES] = {{0}}, t[N][3], columns[STATES * STRIDE] = {0};
  double increment[3][N], traction[3][N], k[2];
  const double *given[3] = {increment[0], increment[1], increment[2]},
               *old[3] = {traction[0], traction[1], traction[2]};
  double *found[3] = {traction[0], traction[1], traction[2]};
  int bad = FAILS(asperity_nstatv(props, 9, NULL, 0) == STATES);
  for (int step = 1; step <= 40; step++) {
    for (int i = 0; i < N; i++)
      for (int j = 0; j < 3; j++) {
        end[i][j] = (j == 0 ? -0.001 : 0.005 * j) * step * (i + 1);
        increment[j][i] = end[i][j] - at[i][j];
      }
    bad += FAILS(asperity_update(props, 9, 0.0, N, at[0], end[0], NULL, NULL, STATES, state[0], t[0], NULL, NULL, 0) ==
                 ASPERITY_OK);
    bad += FAILS(asperity_block(props, 9, 0.0, N, given, step > 1 ? old : NULL, STRIDE, STATES, columns, found) ==
                 ASPERITY_OK);
    for (int i = 0; i < N; i++)
      for (int j = 0; j < 3; j++) {
        bad += DIFFERS(t[i][j], traction[j][i], 1e-10);
        at[i][j] = end[i][j];
      }
  }
  for (int i = 0; i < N; i++) bad += DIFFERS(state[i][3], columns[3 * STRIDE + i], 1e-10);
  for (int j = 0; j < STATES; j++) bad += FAILS(columns[j * STRIDE + N] == 0.0);
  increment[0][1] = NAN;
  const double friction = columns[3 * STRIDE];
  bad += FAILS(asperity_block(props, 9, 0.0, N, given, old, STRIDE, STATES, columns, found) != ASPERITY_OK);
  bad += FAILS(isnan(traction[1][2]) && columns[3 * STRIDE] == friction);
  bad += FAILS(asperity_block(props, 9, 0.0, 0, NULL, NULL, 0, STATES, NULL, NULL) == ASPERITY_OK);
  /* the closed contact is kc = 2 times as stiff as the bond: a pressure shows it */
  const double stiff[] = {3.0, 0.3, 0.9, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0};
  double one[11] = {0}, closed[3] = {-1e-4, 0.0, 0.0}, force[3];
  bad += FAILS(asperity_stiffness(stiff, 16, k, NULL, 0) == ASPERITY_OK);
  bad +=
      FAILS(asperity_update(stiff, 16, 0.0, 1, NULL, closed, NULL, NULL, 11, one, force, NULL, NULL, 0) == ASPERITY_OK);
  bad += DIFFERS(force[0] / closed[0], k[0], 1e-10 * k[0]);
  bad += DIFFERS(0.5, k[1] / k[0], 1e-12);
  return bad + FAILS(asperity_stiffness(stiff, 3, k, NULL, 0) == ASPERITY_BAD_PROPS);
}

int main(void) {
  int (*const tests[])(void) = {version_is_text,
                                blocks_by_columns_are_points,
                                kernels_are_those_of_the_environment,
                                nstatv_counts_planes,
                                bad_props_are_named_all_at_once,
                                tangent_comes_by_rows,
                                friction_keeps_the_bound_of_the_aim,
                                null_start_and_null_tangent,
                                null_arrays,
                                negative_counts_are_told_as_they_came,
                                iterate_has_all_but_the_dissipated_energies,
                                initial_state_carries_the_traction,
                                water_is_part_of_the_total_traction,
                                planes_have_the_normals_of_the_pattern,
                                warnings_are_counted,
                                stiffnesses_make_a_joint_without_bond,
                                threads_of_the_host_have_their_own_points};
  return check_run(sizeof tests / sizeof tests[0], tests);
}
