/* A problem with events as the program in events_main.c runs it. */
#ifndef BENCHMARK_EVENTS_H
#define BENCHMARK_EVENTS_H

#include <math.h>
#include "problem.h"

/* What a problem remembers between events, handed to every callback. */
typedef struct {
  sunindextype size;  /* cells of the array */
  int relations;      /* the array has its relations */
  int mode, second;   /* state of a diode, of a pair of diodes, of friction */
  int on;             /* state of the driven switch */
  int direction[2];   /* in which the first root functions are to cross zero; 0 both */
  double next;        /* next event known beforehand */
  long count;         /* periods so far */
  long residuals, jacobians, roots;
} Machine;

typedef struct {
  const char *name;
  sunindextype unknowns, nonzeros;
  int roots;
  double stop_time;
  double horizon; /* IDA is asked for so much at once; the first step is a thousandth of it */
  IDAResFn residual;
  IDALsJacFn jacobian;
  IDARootFn root;
  void (*start)(Machine *, double *y, double *yp);
  void (*differential)(const Machine *, double *id);
  /* At an event: crossed[k] is not 0 where root k is, all are 0 at a time event. Changes the modes,
   * and y and y' to consistent values after it. */
  void (*event)(Machine *, double t, const int *crossed, double *y, double *yp);
} EventProblem;

EventProblem ball_problem(void);
EventProblem stick_slip_problem(void);
EventProblem half_wave_problem(void);
EventProblem bridge_problem(void);
EventProblem pwm_problem(void);
EventProblem buck_problem(void);
EventProblem array_problem(sunindextype cells, int relations);

#endif
