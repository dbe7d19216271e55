#include <math.h>

/* PROPS: E (kPa), nu, phi (degrees). STATEV(1): plastic shear strain. */
void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl, double *ddsddt,
           double *drplde, double *drpldt, double *stran, double *dstran, double *time, double *dtime, double *temp,
           double *dtemp, double *predef, double *dpred, char *cmname, int *ndi, int *nshr, int *ntens, int *nstatv,
           double *props)
{
    double nu = props[1], g = props[0]/(2 + 2*nu), lame = 2*g*nu/(1 - 2*nu);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            ddsdde[6*j+i] = (i < 3 && j < 3)*lame + (i == j)*(i < 3 ? 2*g : g);
            stress[i] += ddsdde[6*j+i]*dstran[j];
        }
    double mean = (stress[0] + stress[1] + stress[2])/3, square = 0;
    for (int i = 0; i < 6; i++)
        square += i < 3 ? pow(stress[i] - mean, 2) : 2*pow(stress[i], 2);
    double q = fmax(sqrt(1.5*square), 1e-9), strength = fmax(-mean, 0)*sqrt(3)*sin(props[2]*acos(-1)/180);
    if (q <= strength) return;
    for (int i = 0; i < 6; i++)
        stress[i] = (stress[i] - (i < 3)*mean)*strength/q + (i < 3)*fmin(mean, 0);
    statev[0] += (q - strength)/(3*g);
}
