/* asperity: interface law for rough quasi-brittle interfaces (damage, friction, interlocking), C API.
 *
 * Components are (N, Tx, Ty), tension positive; separation in length, traction in stress, any consistent units.
 * docs/reference/contract.md describes PROPS and STATEV. The functions keep no data between calls, so several threads
 * may call them at once. A message buffer may be NULL. A message that does not fit is cut. A zero ends every text. */
#ifndef ASPERITY_H
#define ASPERITY_H

#ifdef __cplusplus
extern "C" {
#endif

/* status codes */
enum asperity_status {
  ASPERITY_OK = 0,
  ASPERITY_BAD_PROPS = 1,      /* a material constant is out of its range */
  ASPERITY_FEW_PROPS = 2,      /* fewer constants than the material needs */
  ASPERITY_FEW_STATEV = 3,     /* nstatv smaller than asperity_nstatv */
  ASPERITY_BAD_NTENS = 4,      /* number of components that no host has (UMAT only) */
  ASPERITY_BAD_SEPARATION = 5, /* a separation is not finite, or too large */
  ASPERITY_BAD_STATE = 6,      /* a state is not finite, or a damage is outside 0..1 */
  ASPERITY_BAD_SIZE = 7,       /* a negative number of points or of bytes of a message, or an array that is NULL */
  ASPERITY_BAD_TIME = 8,       /* viscous damage: a time increment is missing, not finite or negative */
  ASPERITY_BAD_INITIAL = 9,    /* an initial traction that the state cannot carry */
  ASPERITY_BAD_WATER = 10      /* a water pressure is missing, not finite or negative */
};

/* Version of the library as text; returns its length. */
int asperity_version(char *text, int size);

/* Kernels that run. 3: for x86-64-v3 (AVX2, FMA); 1: for any x86-64; 0: the library has one set of kernels.
 * The processor decides when the library is loaded; ASPERITY_ISA=v1 in the environment chooses 1. */
int asperity_isa(void);

/* Number of state variables per point, or 0 if props[nprops] is not admissible (reasons in message). PROPS 25, implex,
 * must be 0: with implex > 0 the UMAT needs 7 + Np more for Np planes. */
int asperity_nstatv(const double *props, int nprops, char *message, int size);

/* Set the offset (state variables 6 to 8) of n states, before their first increment, so that each carries a traction.
 *   traction double[n][3], finite
 *   state    double[n][nstatv], state of the planes (all zero: virgin) -> with offset, damage, slips and stored energy
 * The traction grows proportionally from the traction that the state carries. An asperity_update with s = 0 then
 * returns the given traction. Returns ASPERITY_OK, or the status of the first rejected point. The states of that point
 * and of those after it do not change; those before it have their offset, and a second call with them keeps it. */
int asperity_initial_state(const double *props, int nprops, int n, const double *traction, int nstatv, double *state,
                           char *message, int size);

/* Update n points over one increment.
 *   dt       duration of the increment, >= 0; used only if tau_v or c > 0 (PROPS 13, 24)
 *   s_old    double[n][3], separation at the start (used by the energies, and with wear or the guard by the traction); NULL: zero
 *   s        double[n][3], separation at the end
 *   aim      double[n][3], separation of which damage, friction bound and facets make traction and tangent (symmetric)
 *            in place of those of s; the state is that of s all the same; NULL: none
 *   p        double[n], water pressure in the joint at the end, >= 0: the traction is total; NULL: 0
 *   state    double[n][nstatv], state variables, start -> end; all zero: virgin
 *   traction double[n][3], traction at the end
 *   tangent  double[n][3][3], d traction_i / d s_j (not symmetric without aim); NULL: not computed
 * Returns ASPERITY_OK, or the status of the first rejected point; then only the message is written. */
int asperity_update(const double *props, int nprops, double dt, int n, const double *s_old, const double *s,
                    const double *aim, const double *p, int nstatv, double *state, double *traction, double *tangent,
                    char *message, int size);

/* The same for an iterate of a host's method of Newton: in the states rupture and friction (3 and 4), and with fc the
 * energy of crushing (the last one), are NaN, as they may take most of the time of a long increment. Such a state is
 * refused as a start: asperity_update takes the accepted end. */
int asperity_iterate(const double *props, int nprops, double dt, int n, const double *s_old, const double *s,
                     const double *aim, const double *p, int nstatv, double *state, double *traction, double *tangent,
                     char *message, int size);

/* Unit normals double[n][3] and weights double[n] of the first n planes of PROPS. Returns the number of all planes, or 0 if
 * props[nprops] is not admissible. */
int asperity_planes(const double *props, int nprops, int n, double *normals, double *weights);

/* Warnings about admissible constants that are outside the law's range of validity, a line for each in message; returns
 * their number.
 *   pressure, tension  largest compression and largest prescribed normal traction, >= 0
 *   slip               largest slip; 0: not known */
int asperity_warn(const double *props, int nprops, double pressure, double tension, double slip, char *message,
                  int size);

/* Largest increment of slip that an FE code should take with wear, as a sentence; returns its length, 0 without wear. */
int asperity_slip_increment(const double *props, int nprops, double pressure, double slip, char *text, int size);

/* Set the entries of PROPS (sigma0, Gc, eta, kc, sigma02, Gc2, damage0) of a joint without bond of these stiffnesses in
 * closing and in shear; the others do not change. */
void asperity_joint(double kn, double ks, double *props, int nprops);

/* Update n points of a host that passes increments, by columns, as the VUMAT does with the thickness 1.
 *   increment  three columns double[n] of the separation: N, Tx, Ty
 *   old        three columns double[n], traction at the start: initial traction of points that were never called; NULL: 0
 *   state      nstatv columns, each stride >= n after the one before; 6 to 8 have the whole separation; start -> end
 *   traction   three columns double[n], traction at the end
 * Returns ASPERITY_OK; else the message is on standard error, the traction is NaN and the state does not change. */
int asperity_block(const double *props, int nprops, double dt, int n, const double *const increment[3],
                   const double *const old[3], int stride, int nstatv, double *state, double *const traction[3]);

/* Bounds double[2] of the stiffness in N and in the plane of a closed joint, for the time step of explicit hosts: without
 * the hyperbola of closure and the dashpot. Returns ASPERITY_OK, or ASPERITY_BAD_PROPS with the reasons in message. */
int asperity_stiffness(const double *props, int nprops, double stiffness[2], char *message, int size);

/* UMAT of Abaqus/Standard, CalculiX and Kratos (Fortran calling convention, DDSDDE by columns). */
void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
           double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
           const double *time, const double *dtime, const double *temp, const double *dtemp, const double *predef,
           const double *dpred, const char *cmname, const int *ndi, const int *nshr, const int *ntens,
           const int *nstatv, const double *props, const int *nprops, const double *coords, const double *drot,
           double *pnewdt, const double *celent, const double *dfgrd0, const double *dfgrd1, const int *noel,
           const int *npt, const int *layer, const int *kspt, const int *kstep, const int *kinc);

/* VUMAT of Abaqus/Explicit for cohesive elements, in double and in single precision (Fortran calling convention, arrays
 * (nblock, *) by columns; docs/how-to/abaqus.md). */
void vumat_(const int *nblock, const int *ndir, const int *nshr, const int *nstatev, const int *nfieldv,
            const int *nprops, const int *lanneal, const double *stepTime, const double *totalTime, const double *dt,
            const char *cmname, const double *coordMp, const double *charLength, const double *props,
            const double *density, const double *strainInc, const double *relSpinInc, const double *tempOld,
            const double *stretchOld, const double *defgradOld, const double *fieldOld, const double *stressOld,
            const double *stateOld, const double *enerInternOld, const double *enerInelasOld, const double *tempNew,
            const double *stretchNew, const double *defgradNew, const double *fieldNew, double *stressNew,
            double *stateNew, double *enerInternNew, double *enerInelasNew);
void vumat_single_(const int *nblock, const int *ndir, const int *nshr, const int *nstatev, const int *nfieldv,
                   const int *nprops, const int *lanneal, const float *stepTime, const float *totalTime,
                   const float *dt, const char *cmname, const float *coordMp, const float *charLength,
                   const float *props, const float *density, const float *strainInc, const float *relSpinInc,
                   const float *tempOld, const float *stretchOld, const float *defgradOld, const float *fieldOld,
                   const float *stressOld, const float *stateOld, const float *enerInternOld,
                   const float *enerInelasOld, const float *tempNew, const float *stretchNew, const float *defgradNew,
                   const float *fieldNew, float *stressNew, float *stateNew, float *enerInternNew,
                   float *enerInelasNew);

#ifdef __cplusplus
}
#endif

#endif
