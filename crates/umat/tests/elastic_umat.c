/* A user material of Abaqus for the tests: linear elasticity, PROPS = E, nu; STATEV(1) counts the calls,
   STATEV(2) holds the volumetric strain. With fewer than two properties it asks for a shorter step. */
#include <stdlib.h>

void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
           double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
           const double *time, const double *dtime, const double *temp, const double *dtemp,
           const double *predef, const double *dpred, const char *cmname, const int *ndi, const int *nshr,
           const int *ntens, const int *nstatv, const double *props, const int *nprops, const double *coords,
           const double *drot, double *pnewdt, const double *celent, const double *dfgrd0,
           const double *dfgrd1, const int *noel, const int *npt, const int *layer, const int *kspt,
           const int *kstep, const int *kinc, unsigned long length)
{
    if (*nprops < 2) {
        *pnewdt = 0.5;
        return;
    }
    double e = props[0], nu = props[1];
    double g = e / (2.0 * (1.0 + nu)), lame = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    int n = *ntens;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            ddsdde[j * n + i] = i < 3 && j < 3 ? lame + (i == j ? 2.0 * g : 0.0) : (i == j ? g : 0.0);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            stress[i] += ddsdde[j * n + i] * dstran[j];
    if (*nstatv >= 2) {
        statev[0] += 1.0;
        statev[1] = stran[0] + stran[1] + stran[2] + dstran[0] + dstran[1] + dstran[2];
    }
}

/* The same with a stiffness that is no number as soon as there is strain. */
void nan_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
          double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
          const double *time, const double *dtime, const double *temp, const double *dtemp,
          const double *predef, const double *dpred, const char *cmname, const int *ndi, const int *nshr,
          const int *ntens, const int *nstatv, const double *props, const int *nprops, const double *coords,
          const double *drot, double *pnewdt, const double *celent, const double *dfgrd0,
          const double *dfgrd1, const int *noel, const int *npt, const int *layer, const int *kspt,
          const int *kstep, const int *kinc, unsigned long length)
{
    umat_(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, predef, dpred,
          cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt,
          kstep, kinc, length);
    if (dstran[0] != 0.0)
        ddsdde[0] = 0.0 / (ddsdde[0] - ddsdde[0]);
}

/* The same; STATEV(1) to STATEV(4) are JSTEP(1) to JSTEP(4), as current user materials declare it. */
void jstep_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
            double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
            const double *time, const double *dtime, const double *temp, const double *dtemp,
            const double *predef, const double *dpred, const char *cmname, const int *ndi, const int *nshr,
            const int *ntens, const int *nstatv, const double *props, const int *nprops, const double *coords,
            const double *drot, double *pnewdt, const double *celent, const double *dfgrd0,
            const double *dfgrd1, const int *noel, const int *npt, const int *layer, const int *kspt,
            const int *jstep, const int *kinc, unsigned long length)
{
    umat_(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, predef, dpred,
          cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt,
          jstep, kinc, length);
    for (int i = 0; i < 4; i++)
        statev[i] = jstep[i];
}

/* Ends the program with success, as soon as there is strain. */
void exit_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
           double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
           const double *time, const double *dtime, const double *temp, const double *dtemp,
           const double *predef, const double *dpred, const char *cmname, const int *ndi, const int *nshr,
           const int *ntens, const int *nstatv, const double *props, const int *nprops, const double *coords,
           const double *drot, double *pnewdt, const double *celent, const double *dfgrd0,
           const double *dfgrd1, const int *noel, const int *npt, const int *layer, const int *kspt,
           const int *kstep, const int *kinc, unsigned long length)
{
    umat_(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, predef, dpred,
          cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt,
          kstep, kinc, length);
    if (dstran[0] != 0.0)
        exit(0);
}
