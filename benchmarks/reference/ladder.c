/* Diode ladder: per section a coil with resistance in series, then to ground a capacitor and a
 * diode, and a conductor to a bias rail. Unknowns of section k: coil current, node voltage,
 * diode current. The last section feeds a load conductance. */
#include <math.h>
#include "problem.h"

static const double R = 1.0, L = 1e-6, C = 1e-6, SATURATION = 1e-9, THERMAL = 0.05;
static const double G_LOAD = 1.0, G_BIAS = 0.05, FREQUENCY = 1e3, BIAS = 0.7;

static int residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  Work *work = user;
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr);
  double left = sin(2 * M_PI * FREQUENCY * t), rail = BIAS * left;
  sunindextype last = work->size - 1;
  work->residuals++;
  for (sunindextype k = 0; k <= last; k++, y += 3, yp += 3, r += 3) {
    double i = y[0], v = y[1], diode = y[2];
    double onward = k < last ? y[3] : G_LOAD * v;
    r[0] = L * yp[0] + R * i + v - left;
    r[1] = C * yp[1] + diode + onward - i - G_BIAS * (rail - v);
    r[2] = diode - SATURATION * (exp(v / THERMAL) - 1);
    left = v;
  }
  return 0;
}

static int jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                    void *user, N_Vector a, N_Vector b, N_Vector c) {
  Work *work = user;
  const double *y = N_VGetArrayPointer(yy);
  Columns m = columns_of(J);
  sunindextype last = work->size - 1;
  (void)t, (void)yyp, (void)rr, (void)a, (void)b, (void)c;
  work->jacobians++;
  for (sunindextype k = 0, row = 0; k <= last; k++, row += 3) {
    column(&m); /* coil current */
    if (k > 0) entry(&m, row - 2, 1);
    entry(&m, row, L * cj + R);
    entry(&m, row + 1, -1);
    column(&m); /* node voltage */
    entry(&m, row, 1);
    entry(&m, row + 1, C * cj + G_BIAS + (k < last ? 0 : G_LOAD));
    entry(&m, row + 2, -SATURATION / THERMAL * exp(y[row + 1] / THERMAL));
    if (k < last) entry(&m, row + 3, -1);
    column(&m); /* diode current */
    entry(&m, row + 1, 1);
    entry(&m, row + 2, 1);
  }
  finish(&m);
  return 0;
}

/* Everything is zero at the start, the derivatives too: both sources begin with 0 V. */
static void start(const Work *work, double *y, double *yp) {
  for (sunindextype k = 0; k < 3 * work->size; k++) y[k] = yp[k] = 0;
}

static void differential(const Work *work, double *id) {
  for (sunindextype k = 0; k < 3 * work->size; k++) id[k] = k % 3 != 2;
}

Problem ladder_problem(sunindextype sections) {
  Problem p = {"ladder", 3 * sections, 9 * sections, 2e-3, 0,
               1, residual, jacobian, start, differential};
  return p;
}
