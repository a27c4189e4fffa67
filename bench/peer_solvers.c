#include "peer_solvers.h"
#include "clock.h"
#include "memory.h"
#include <math.h>
#include <string.h>

double pc_peer_residual(const pc_system *system, pc_context *ctx, const double *b, const double *x) {
    size_t n = system->row_count * (size_t)pc_block_width(system->kind);
    double *y = NULL, error = 0, size = 0;
    if (pc_new(&y, ctx, n) != PC_OK) return NAN;
    pc_system_apply(y, system, x);
    for (size_t i = 0; i < n; i++) {
        error += (y[i] - b[i]) * (y[i] - b[i]);
        size += b[i] * b[i];
    }
    pc_free(ctx, y);
    return sqrt(error / size);
}

#ifdef PC_HAVE_CHOLMOD
#include <cholmod.h>

/* The upper triangle by columns: complex Hermitian for COMPLEX, real for the others. */
static cholmod_sparse *cholmod_matrix(const pc_system *s, cholmod_common *c) {
    const bool complex_numbers = s->kind == PC_BLOCK_COMPLEX;
    const int w = complex_numbers ? 1 : pc_block_width(s->kind);
    size_t rows = s->row_count * (size_t)w, most = 0;
    const size_t per_entry = s->kind == PC_BLOCK_TURNED ? 8 : 1;
    most = s->start[s->row_count] / 2 * per_entry + rows;
    cholmod_sparse *a = cholmod_l_allocate_sparse(rows, rows, most, 1, 1, 1,
                                                  complex_numbers ? CHOLMOD_COMPLEX : CHOLMOD_REAL, c);
    if (!a) return NULL;
    SuiteSparse_long *p = a->p, *i = a->i, at = 0;
    double *x = a->x, block[16];
    for (pc_index col = 0; col < s->row_count; col++)
        for (int k = 0; k < w; k++) {
            p[(size_t)col * (size_t)w + (size_t)k] = at;
            for (size_t e = s->start[col]; e < s->start[col + 1] && s->column[e] < col; e++) {
                if (complex_numbers) {
                    /* Entry (column, col) is the conjugate of (col, column). */
                    i[at] = s->column[e];
                    x[2 * at] = s->value[2 * e];
                    x[2 * at + 1] = -s->value[2 * e + 1];
                    at++;
                    continue;
                }
                pc_system_block(block, s, e);
                for (int r = 0; r < w; r++)
                    if (block[w * k + r] != 0) {
                        i[at] = (SuiteSparse_long)s->column[e] * w + r;
                        x[at++] = block[w * k + r];
                    }
            }
            i[at] = (SuiteSparse_long)col * w + k;
            if (complex_numbers) {
                x[2 * at] = s->diagonal[col];
                x[2 * at + 1] = 0;
            } else {
                x[at] = s->diagonal[col];
            }
            at++;
        }
    p[rows] = at;
    return a;
}

pc_status pc_peer_cholmod(pc_peer_result *result, pc_context *ctx, const pc_system *system, const double *b,
                          double *x, const double tolerance[2]) {
    cholmod_common c;
    const bool complex_numbers = system->kind == PC_BLOCK_COMPLEX;
    const size_t n = system->row_count * (size_t)pc_block_width(system->kind);
    (void)tolerance;
    cholmod_l_start(&c);
    c.nmethods = 1;
    c.method[0].ordering = CHOLMOD_METIS;
    c.supernodal = CHOLMOD_SUPERNODAL;
    cholmod_sparse *a = cholmod_matrix(system, &c);
    double cpu = pc_clock_cpu(), wall = pc_clock_wall();
    cholmod_factor *l = a ? cholmod_l_analyze(a, &c) : NULL;
    bool good = l && cholmod_l_factorize(a, l, &c) && c.status == CHOLMOD_OK;
    result->setup_cpu = pc_clock_cpu() - cpu, result->setup_wall = pc_clock_wall() - wall;
    cholmod_dense *right =
        cholmod_l_allocate_dense(complex_numbers ? n / 2 : n, 1, complex_numbers ? n / 2 : n,
                                 complex_numbers ? CHOLMOD_COMPLEX : CHOLMOD_REAL, &c);
    if (right) memcpy(right->x, b, n * sizeof *b);
    cpu = pc_clock_cpu(), wall = pc_clock_wall();
    cholmod_dense *solution = good && right ? cholmod_l_solve(CHOLMOD_A, l, right, &c) : NULL;
    for (int k = 0; k < 2; k++)
        result->solve_cpu[k] = pc_clock_cpu() - cpu, result->solve_wall[k] = pc_clock_wall() - wall;
    if (solution) memcpy(x, solution->x, n * sizeof *x);
    good = good && solution;
    cholmod_l_free_dense(&solution, &c);
    cholmod_l_free_dense(&right, &c);
    cholmod_l_free_factor(&l, &c);
    cholmod_l_free_sparse(&a, &c);
    cholmod_l_finish(&c);
    if (!good) return pc_fail(ctx, PC_E_NOMEM, "CHOLMOD failed (status %d)", c.status);
    result->residual[0] = result->residual[1] = pc_peer_residual(system, ctx, b, x);
    return PC_OK;
}
#else
pc_status pc_peer_cholmod(pc_peer_result *result, pc_context *ctx, const pc_system *system, const double *b,
                          double *x, const double tolerance[2]) {
    (void)result, (void)system, (void)b, (void)x, (void)tolerance;
    return pc_fail(ctx, PC_E_USAGE, "not installed: CHOLMOD (libsuitesparse-dev)");
}
#endif

#ifdef PC_HAVE_HYPRE
#include <HYPRE.h>
#include <HYPRE_krylov.h>
#include <HYPRE_parcsr_ls.h>

static pc_status hypre_matrix(HYPRE_IJMatrix *a, pc_context *ctx, const pc_system *s) {
    const int w = pc_block_width(s->kind), rows = (int)s->row_count * w;
    HYPRE_IJMatrixCreate(MPI_COMM_WORLD, 0, rows - 1, 0, rows - 1, a);
    HYPRE_IJMatrixSetObjectType(*a, HYPRE_PARCSR);
    HYPRE_IJMatrixInitialize(*a);
    for (pc_index i = 0; i < s->row_count; i++)
        for (int r = 0; r < w; r++) {
            enum { MOST = 4096 };
            HYPRE_BigInt column[MOST], row = (HYPRE_BigInt)i * w + r;
            double value[MOST], block[16];
            HYPRE_Int count = 0;
            column[count] = row, value[count++] = s->diagonal[i];
            for (size_t e = s->start[i]; e < s->start[i + 1] && count + w <= MOST; e++) {
                pc_system_block(block, s, e);
                for (int k = 0; k < w; k++)
                    if (block[w * r + k] != 0)
                        column[count] = (HYPRE_BigInt)s->column[e] * w + k, value[count++] = block[w * r + k];
            }
            HYPRE_IJMatrixSetValues(*a, 1, &count, &row, column, value);
        }
    if (HYPRE_IJMatrixAssemble(*a) != 0) return pc_fail(ctx, PC_E_NOMEM, "hypre: no matrix");
    return PC_OK;
}

static HYPRE_IJVector hypre_vector(int rows, const double *from, HYPRE_ParVector *inside) {
    HYPRE_IJVector v;
    void *object;
    HYPRE_IJVectorCreate(MPI_COMM_WORLD, 0, rows - 1, &v);
    HYPRE_IJVectorSetObjectType(v, HYPRE_PARCSR);
    HYPRE_IJVectorInitialize(v);
    for (HYPRE_BigInt i = 0; i < rows; i++) {
        double value = from ? from[i] : 0;
        HYPRE_IJVectorSetValues(v, 1, &i, &value);
    }
    HYPRE_IJVectorAssemble(v);
    HYPRE_IJVectorGetObject(v, &object);
    *inside = (HYPRE_ParVector)object;
    return v;
}

/* The settings that served it best on such systems: HMIS, extended+i, l1 Gauss-Seidel, the unknowns of a row
 * as functions. */
static HYPRE_Solver boomeramg(int functions) {
    HYPRE_Solver amg;
    HYPRE_BoomerAMGCreate(&amg);
    HYPRE_BoomerAMGSetCoarsenType(amg, 10);
    HYPRE_BoomerAMGSetInterpType(amg, 6);
    HYPRE_BoomerAMGSetPMaxElmts(amg, 4);
    HYPRE_BoomerAMGSetRelaxType(amg, 8);
    HYPRE_BoomerAMGSetNumFunctions(amg, functions);
    HYPRE_BoomerAMGSetMaxIter(amg, 1);
    HYPRE_BoomerAMGSetTol(amg, 0);
    return amg;
}

pc_status pc_peer_boomeramg(pc_peer_result *result, pc_context *ctx, const pc_system *system, const double *b,
                            double *x, const double tolerance[2]) {
    const int rows = (int)system->row_count * pc_block_width(system->kind);
    pc_status status = PC_OK;
    HYPRE_IJMatrix a;
    HYPRE_ParVector right, answer;
    void *object;
    MPI_Init(NULL, NULL);
    HYPRE_Init();
    status = hypre_matrix(&a, ctx, system);
    if (status != PC_OK) return status;
    HYPRE_IJMatrixGetObject(a, &object);
    HYPRE_ParCSRMatrix matrix = (HYPRE_ParCSRMatrix)object;
    HYPRE_IJVector of_b = hypre_vector(rows, b, &right);
    HYPRE_IJVector of_x = hypre_vector(rows, NULL, &answer);
    HYPRE_Solver amg = boomeramg(pc_block_width(system->kind)), pcg;
    HYPRE_ParCSRPCGCreate(MPI_COMM_WORLD, &pcg);
    HYPRE_PCGSetMaxIter(pcg, 2000);
    HYPRE_PCGSetTwoNorm(pcg, 1);
    HYPRE_PCGSetPrecond(pcg, (HYPRE_PtrToSolverFcn)HYPRE_BoomerAMGSolve,
                        (HYPRE_PtrToSolverFcn)HYPRE_BoomerAMGSetup, amg);
    double cpu = pc_clock_cpu(), wall = pc_clock_wall();
    HYPRE_ParCSRPCGSetup(pcg, matrix, right, answer);
    result->setup_cpu = pc_clock_cpu() - cpu, result->setup_wall = pc_clock_wall() - wall;
    for (int k = 0; k < 2; k++) {
        HYPRE_Int its = 0;
        HYPRE_ParVectorSetConstantValues(answer, 0);
        HYPRE_PCGSetTol(pcg, tolerance[k]);
        cpu = pc_clock_cpu(), wall = pc_clock_wall();
        HYPRE_ParCSRPCGSolve(pcg, matrix, right, answer);
        result->solve_cpu[k] = pc_clock_cpu() - cpu, result->solve_wall[k] = pc_clock_wall() - wall;
        HYPRE_PCGGetNumIterations(pcg, &its);
        result->iterations[k] = its;
        for (HYPRE_BigInt i = 0; i < rows; i++)
            HYPRE_IJVectorGetValues(of_x, 1, &i, &x[i]);
        result->residual[k] = pc_peer_residual(system, ctx, b, x);
    }
    HYPRE_ParCSRPCGDestroy(pcg);
    HYPRE_BoomerAMGDestroy(amg);
    HYPRE_IJMatrixDestroy(a);
    HYPRE_IJVectorDestroy(of_b);
    HYPRE_IJVectorDestroy(of_x);
    HYPRE_Finalize();
    MPI_Finalize();
    return PC_OK;
}
#else
pc_status pc_peer_boomeramg(pc_peer_result *result, pc_context *ctx, const pc_system *system, const double *b,
                            double *x, const double tolerance[2]) {
    (void)result, (void)system, (void)b, (void)x, (void)tolerance;
    return pc_fail(ctx, PC_E_USAGE, "not installed: BoomerAMG (libhypre-dev)");
}
#endif
