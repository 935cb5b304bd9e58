/* Bridge rectifier: a sine source with a series resistor floats between nodes a and b, which have
 * small capacitances to ground; four diodes feed a smoothing capacitor and a load at node p.
 * Unknowns: v_a, v_b, v_p, the currents of the diodes a-p, b-p, 0-a, 0-b, the source current. */
#include <math.h>
#include "problem.h"

static const double R_SOURCE = 1, C_NODE = 1e-9, C_SMOOTH = 1e-3, R_LOAD = 100;
static const double SATURATION = 1e-12, THERMAL = 0.026, AMPLITUDE = 10, FREQUENCY = 50;

static double diode(double v) { return SATURATION * (exp(v / THERMAL) - 1); }
static double slope(double v) { return SATURATION / THERMAL * exp(v / THERMAL); }

static int residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr);
  double a = y[0], b = y[1], p = y[2], source = y[7];
  ((Work *)user)->residuals++;
  r[0] = C_NODE * yp[0] + y[3] - y[5] - source;
  r[1] = C_NODE * yp[1] + y[4] - y[6] + source;
  r[2] = C_SMOOTH * yp[2] + p / R_LOAD - y[3] - y[4];
  r[3] = y[3] - diode(a - p);
  r[4] = y[4] - diode(b - p);
  r[5] = y[5] - diode(-a);
  r[6] = y[6] - diode(-b);
  r[7] = R_SOURCE * source + a - b - AMPLITUDE * sin(2 * M_PI * FREQUENCY * t);
  return 0;
}

static int jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                    void *user, N_Vector n1, N_Vector n2, N_Vector n3) {
  const double *y = N_VGetArrayPointer(yy);
  double a = y[0], b = y[1], p = y[2];
  double ap = slope(a - p), bp = slope(b - p), ga = slope(-a), gb = slope(-b);
  Columns m = columns_of(J);
  (void)t, (void)yyp, (void)rr, (void)n1, (void)n2, (void)n3;
  ((Work *)user)->jacobians++;
  column(&m); /* v_a */
  entry(&m, 0, C_NODE * cj), entry(&m, 3, -ap), entry(&m, 5, ga), entry(&m, 7, 1);
  column(&m); /* v_b */
  entry(&m, 1, C_NODE * cj), entry(&m, 4, -bp), entry(&m, 6, gb), entry(&m, 7, -1);
  column(&m); /* v_p */
  entry(&m, 2, C_SMOOTH * cj + 1 / R_LOAD), entry(&m, 3, ap), entry(&m, 4, bp);
  column(&m); /* diode a-p */
  entry(&m, 0, 1), entry(&m, 2, -1), entry(&m, 3, 1);
  column(&m); /* diode b-p */
  entry(&m, 1, 1), entry(&m, 2, -1), entry(&m, 4, 1);
  column(&m); /* diode 0-a */
  entry(&m, 0, -1), entry(&m, 5, 1);
  column(&m); /* diode 0-b */
  entry(&m, 1, -1), entry(&m, 6, 1);
  column(&m); /* source */
  entry(&m, 0, -1), entry(&m, 1, 1), entry(&m, 7, R_SOURCE);
  finish(&m);
  return 0;
}

/* All voltages and currents are zero; IDA finds the derivatives of the node voltages. */
static void start(const Work *work, double *y, double *yp) {
  (void)work;
  for (int k = 0; k < 8; k++) y[k] = yp[k] = 0;
}

static void differential(const Work *work, double *id) {
  (void)work;
  for (int k = 0; k < 8; k++) id[k] = k < 3;
}

Problem rectifier_problem(void) {
  /* The node capacitances make time constants of a nanosecond: IDA needs a small first step. */
  Problem p = {"rectifier", 8, 24, 0.1, 1e-13, 0, residual, jacobian, start, differential};
  return p;
}
