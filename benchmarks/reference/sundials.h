/* The part of SUNDIALS 7's C interface that these programs use.
 *
 * The wheels that carry SUNDIALS bring libraries without headers. `sunindextype` is the width of
 * the library's indices: 32 bits unless compiled with -DINDEX_BITS=64.
 */
#ifndef BENCHMARK_SUNDIALS_H
#define BENCHMARK_SUNDIALS_H

#include <stdint.h>

#ifndef INDEX_BITS
#define INDEX_BITS 32
#endif
#if INDEX_BITS == 32
typedef int32_t sunindextype;
#else
typedef int64_t sunindextype;
#endif

/* Handles; nobody outside the library looks into them. */
typedef struct context_ *SUNContext;
typedef struct vector_ *N_Vector;
typedef struct matrix_ *SUNMatrix;
typedef struct linear_solver_ *SUNLinearSolver;

enum { SUN_COMM_NULL = 0, CSC_MAT = 0, IDA_NORMAL = 1, IDA_YA_YDP_INIT = 1 };
enum { IDA_TSTOP_RETURN = 1, IDA_ROOT_RETURN = 2 };

typedef int (*IDAResFn)(double t, N_Vector y, N_Vector yp, N_Vector r, void *user);
typedef int (*IDALsJacFn)(double t, double cj, N_Vector y, N_Vector yp, N_Vector r, SUNMatrix J,
                          void *user, N_Vector, N_Vector, N_Vector);
typedef int (*IDARootFn)(double t, N_Vector y, N_Vector yp, double *values, void *user);

int SUNContext_Create(int communicator, SUNContext *);
int SUNContext_Free(SUNContext *);

N_Vector N_VNew_Serial(sunindextype length, SUNContext);
double *N_VGetArrayPointer(N_Vector);
void N_VConst(double value, N_Vector);
void N_VDestroy(N_Vector);

SUNMatrix SUNSparseMatrix(sunindextype rows, sunindextype columns, sunindextype nonzeros,
                          int format, SUNContext);
sunindextype *SUNSparseMatrix_IndexPointers(SUNMatrix);
sunindextype *SUNSparseMatrix_IndexValues(SUNMatrix);
double *SUNSparseMatrix_Data(SUNMatrix);
void SUNMatDestroy(SUNMatrix);

SUNLinearSolver SUNLinSol_KLU(N_Vector, SUNMatrix, SUNContext);
int SUNLinSol_KLUSetOrdering(SUNLinearSolver, int ordering); /* 0: AMD, 1: COLAMD */
int SUNLinSolFree(SUNLinearSolver);

void *IDACreate(SUNContext);
int IDAInit(void *, IDAResFn, double t, N_Vector y, N_Vector yp);
int IDASStolerances(void *, double relative, double absolute);
int IDASetUserData(void *, void *);
int IDASetLinearSolver(void *, SUNLinearSolver, SUNMatrix);
int IDASetJacFn(void *, IDALsJacFn);
int IDASetMaxNumSteps(void *, long);
int IDASetMaxErrTestFails(void *, int);
int IDASetInitStep(void *, double);
int IDASetId(void *, N_Vector);
int IDASetSuppressAlg(void *, int);
int IDACalcIC(void *, int what, double first_output);
int IDAGetConsistentIC(void *, N_Vector y, N_Vector yp);
int IDARootInit(void *, int count, IDARootFn);
int IDAGetRootInfo(void *, int *crossed); /* per function: -1 falling, 1 rising, 0 none */
int IDASetRootDirection(void *, int *direction); /* -1 falling, 1 rising, 0 both */
int IDASetNoInactiveRootWarn(void *);
int IDAReInit(void *, double t, N_Vector y, N_Vector yp);
int IDASetStopTime(void *, double t);
int IDASolve(void *, double target, double *reached, N_Vector y, N_Vector yp, int task);
int IDAGetNumSteps(void *, long *);
int IDAGetNumErrTestFails(void *, long *);
void IDAFree(void **);

#endif
