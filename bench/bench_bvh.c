/* Time to build the tree of boxes over a synthetic scan, and to find the closest points of its own jittered
 * vertices. bench_bvh [MILLION_TRIANGLES] */
#include "bvh.h"
#include "clock.h"
#include "memory.h"
#include "synth.h"
#include "synth_wear.h"
#include <stdio.h>
#include <stdlib.h>

static pc_status measure(pc_context *ctx, double millions) {
    pc_status status = PC_OK;
    pc_mesh mesh = {0}, queries = {0};
    pc_bvh bvh = {0};
    pc_bvh_hit *hits = NULL;
    PC_TRY(pc_synth_sphere(&mesh, ctx, (pc_index)sqrt(millions * 1e6 / 8)));
    PC_TRY(pc_synth_noise(&mesh, ctx, 0.2, 1));
    PC_TRY(pc_mesh_copy(&queries, ctx, &mesh));
    PC_TRY(pc_synth_noise(&queries, ctx, 0.5, 2));
    for (int shuffled = 0; shuffled < 2; shuffled++) {
        if (shuffled) PC_TRY(pc_synth_shuffle(&mesh, ctx, 3));
        double t0 = pc_clock_wall();
        PC_TRY(pc_bvh_make(&bvh, ctx, &mesh));
        double t1 = pc_clock_wall();
        PC_TRY(pc_new(&hits, ctx, queries.vertex_count));
        pc_bvh_closest_all(hits, &bvh, queries.position, queries.vertex_count);
        double t2 = pc_clock_wall(), sum = 0;
        for (size_t i = 0; i < queries.vertex_count; i++)
            sum += hits[i].distance;
        printf("{\"bench\": \"bvh\", \"shuffled\": %s, \"faces\": %u, \"build_s\": %.3f, \"queries\": %u, "
               "\"query_s\": %.3f, \"queries_per_s\": %.3g, \"mean_distance\": %.6g}\n",
               shuffled ? "true" : "false", mesh.face_count, t1 - t0, queries.vertex_count, t2 - t1,
               queries.vertex_count / (t2 - t1), sum / queries.vertex_count);
        pc_bvh_free(&bvh, ctx);
        pc_free(ctx, hits);
        hits = NULL;
    }
done:
    if (status != PC_OK) (void)fprintf(stderr, "bench_bvh: %s\n", pc_context_message(ctx));
    pc_bvh_free(&bvh, ctx);
    pc_free(ctx, hits);
    pc_mesh_free(&mesh, ctx);
    pc_mesh_free(&queries, ctx);
    return status;
}

int main(int argc, char **argv) {
    double millions = argc > 1 ? strtod(argv[1], NULL) : 2.8;
    pc_context *ctx = pc_context_make();
    if (!ctx) return pc_status_exit_code(PC_E_NOMEM);
    pc_status status = measure(ctx, millions);
    pc_context_free(ctx);
    return pc_status_exit_code(status);
}
