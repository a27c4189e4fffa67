/* What the last steps of a minimisation tell about its Hessian: the two loops of L-BFGS (Nocedal 1980) around
 * an approximate inverse that the caller applies. Fits of splines by it: Zheng, Bo, Liu, Wang 2012. */
#ifndef PC_SECANTS_H
#define PC_SECANTS_H

#include "context.h"

enum { PC_SECANTS_KEPT = 5 };

typedef struct pc_secants {
    size_t length;                                           /* numbers of a vector */
    int count, newest;                                       /* pairs, in a ring */
    double *step[PC_SECANTS_KEPT], *change[PC_SECANTS_KEPT]; /* and how the pull fell along it */
    double product[PC_SECANTS_KEPT];                         /* step.change */
    double share[PC_SECANTS_KEPT];
    double *last_pull, *last_step;
    bool has_last;
} pc_secants;

pc_status pc_secants_make(pc_secants *secants, pc_context *ctx, size_t length);
void pc_secants_free(pc_secants *secants, pc_context *ctx);
/* `pull` is minus the gradient where the last step has led. */
void pc_secants_learn(pc_secants *secants, const double *pull);
void pc_secants_forget(pc_secants *secants);
/* Before the approximate inverse is applied to `pull`, and after it to the result, which becomes the step. */
void pc_secants_before(pc_secants *secants, double *pull);
void pc_secants_after(const pc_secants *secants, double *step);
/* The step that is taken, and the pull that it came from. */
void pc_secants_take(pc_secants *secants, const double *step, const double *pull);

#endif
