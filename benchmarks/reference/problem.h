/* A problem as the program in main.c integrates it. */
#ifndef BENCHMARK_PROBLEM_H
#define BENCHMARK_PROBLEM_H

#include "sundials.h"

/* Counters and size, handed to every callback. */
typedef struct {
  sunindextype size; /* sections of the ladder */
  long residuals, jacobians;
} Work;

typedef struct {
  const char *name;
  sunindextype unknowns, nonzeros;
  double stop_time;
  double first_step;   /* seconds; 0 leaves it to IDA */
  int consistent;      /* start() gives consistent y and y' */
  IDAResFn residual;
  IDALsJacFn jacobian; /* writes dF/dy + cj dF/dy' with its pattern, compressed columns */
  void (*start)(const Work *, double *y, double *yp);
  void (*differential)(const Work *, double *id); /* 1 for a state, 0 for an algebraic unknown */
} Problem;

Problem ladder_problem(sunindextype sections);
Problem rectifier_problem(void);
Problem pendulum_problem(void);

/* Columns of a matrix, filled from left to right. */
typedef struct {
  sunindextype *start, *row;
  double *value;
  sunindextype count, column;
} Columns;

static inline Columns columns_of(SUNMatrix J) {
  Columns c = {SUNSparseMatrix_IndexPointers(J), SUNSparseMatrix_IndexValues(J),
               SUNSparseMatrix_Data(J), 0, 0};
  return c;
}
static inline void column(Columns *c) { c->start[c->column++] = c->count; }
static inline void entry(Columns *c, sunindextype row, double value) {
  c->row[c->count] = row;
  c->value[c->count++] = value;
}
static inline void finish(Columns *c) { c->start[c->column] = c->count; }

#endif
