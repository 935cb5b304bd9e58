/* Double pendulum in minimal coordinates: point masses of 1 kg on massless rods of 1 m. Unknowns:
 * both angles from the hanging position, angular velocities, angular accelerations; Lagrange's
 * two equations of motion are the last two rows. */
#include <math.h>
#include "problem.h"

static const double GRAVITY = 9.81, THETA1 = 2.0, THETA2 = 1.0;

static int residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr);
  double c = cos(y[0] - y[1]), s = sin(y[0] - y[1]);
  (void)t;
  ((Work *)user)->residuals++;
  for (int k = 0; k < 4; k++) r[k] = yp[k] - y[k + 2];
  r[4] = 2 * y[4] + c * y[5] + s * y[3] * y[3] + 2 * GRAVITY * sin(y[0]);
  r[5] = c * y[4] + y[5] - s * y[2] * y[2] + GRAVITY * sin(y[1]);
  return 0;
}

static int jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                    void *user, N_Vector n1, N_Vector n2, N_Vector n3) {
  const double *y = N_VGetArrayPointer(yy);
  double c = cos(y[0] - y[1]), s = sin(y[0] - y[1]);
  double first = c * y[3] * y[3] - s * y[5];  /* of the first equation, by the difference */
  double second = -s * y[4] - c * y[2] * y[2];
  Columns m = columns_of(J);
  (void)t, (void)yyp, (void)rr, (void)n1, (void)n2, (void)n3;
  ((Work *)user)->jacobians++;
  column(&m); /* first angle */
  entry(&m, 0, cj), entry(&m, 4, first + 2 * GRAVITY * cos(y[0])), entry(&m, 5, second);
  column(&m); /* second angle */
  entry(&m, 1, cj), entry(&m, 4, -first), entry(&m, 5, GRAVITY * cos(y[1]) - second);
  column(&m); /* velocities */
  entry(&m, 0, -1), entry(&m, 2, cj), entry(&m, 5, -2 * s * y[2]);
  column(&m);
  entry(&m, 1, -1), entry(&m, 3, cj), entry(&m, 4, 2 * s * y[3]);
  column(&m); /* accelerations */
  entry(&m, 2, -1), entry(&m, 4, 2), entry(&m, 5, c);
  column(&m);
  entry(&m, 3, -1), entry(&m, 4, c), entry(&m, 5, 1);
  finish(&m);
  return 0;
}

static void start(const Work *work, double *y, double *yp) {
  double c = cos(THETA1 - THETA2);
  double f1 = -2 * GRAVITY * sin(THETA1), f2 = -GRAVITY * sin(THETA2), det = 2 - c * c;
  (void)work;
  y[0] = THETA1, y[1] = THETA2, y[2] = y[3] = 0;
  y[4] = (f1 - c * f2) / det, y[5] = (2 * f2 - c * f1) / det;
  for (int k = 0; k < 4; k++) yp[k] = y[k + 2];
  yp[4] = yp[5] = 0;
}

static void differential(const Work *work, double *id) {
  (void)work;
  for (int k = 0; k < 6; k++) id[k] = k < 4;
}

Problem pendulum_problem(void) {
  Problem p = {"pendulum", 6, 18, 10, 0, 1, residual, jacobian, start, differential};
  return p;
}
