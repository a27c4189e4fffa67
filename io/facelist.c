#include "facelist.h"
#include "memory.h"
#include "triangulate.h"
#include <string.h>

void pc_facelist_free(pc_facelist *list, pc_context *ctx) {
    pc_free(ctx, list->triangle);
    pc_free(ctx, list->polygon);
    *list = (pc_facelist){0};
}

pc_status pc_facelist_reserve(pc_facelist *list, pc_context *ctx, size_t triangles) {
    pc_status status = PC_OK;
    if (list->triangle && triangles <= list->capacity) return PC_OK;
    if (triangles >= PC_NONE / 3 - 1)
        return pc_fail(ctx, PC_E_FORMAT, "%zu triangles exceed the 32-bit indices of this version",
                       triangles);
    PC_TRY(pc_resize_bytes((void **)&list->triangle, ctx, triangles, 3 * sizeof(pc_index)));
    list->capacity = triangles;
done:
    return status;
}

pc_status pc_facelist_reserve_polygons(pc_facelist *list, pc_context *ctx, size_t polygons) {
    pc_status status = PC_OK;
    if (list->polygon && polygons <= list->polygon_capacity) return PC_OK;
    PC_TRY(pc_resize(&list->polygon, ctx, polygons));
    list->polygon_capacity = polygons;
done:
    return status;
}

pc_status pc_facelist_add(pc_facelist *list, pc_context *ctx, const pc_index *corner, size_t sides) {
    pc_status status = PC_OK;
    if (list->count + sides - 2 > list->capacity)
        PC_TRY(pc_facelist_reserve(list, ctx, list->capacity + list->capacity / 2 + sides + 1024));
    if (sides > 3) {
        if (list->polygon_count == list->polygon_capacity)
            PC_TRY(pc_facelist_reserve_polygons(list, ctx, 2 * list->polygon_capacity + 1024));
        list->polygon[list->polygon_count++] =
            (pc_polygon){.first = (pc_index)list->count, .sides = (pc_index)sides};
    }
    pc_index *t = list->triangle + 3 * list->count;
    for (size_t i = 2; i < sides; i++, t += 3) {
        t[0] = corner[0];
        t[1] = corner[i - 1];
        t[2] = corner[i];
    }
    list->count += sides - 2;
done:
    return status;
}

static pc_status cut_polygons(const pc_facelist *list, pc_context *ctx, const double *position) {
    pc_status status = PC_OK;
    pc_cutter cutter = {0};
    for (size_t i = 0; i < list->polygon_count; i++) {
        if (i % 65536 == 0) PC_TRY(pc_check_interrupt(ctx));
        PC_TRY(pc_cutter_cut(&cutter, ctx, list->triangle + 3 * (size_t)list->polygon[i].first,
                             list->polygon[i].sides, position));
    }
done:
    pc_cutter_free(&cutter, ctx);
    return status;
}

pc_status pc_facelist_finish(pc_facelist *list, pc_context *ctx, pc_mesh *mesh) {
    pc_status status = PC_OK;
    PC_TRY(cut_polygons(list, ctx, mesh->position));
    /* Room left over from growing is given back only where it is worth a copy. */
    if (list->capacity - list->count > list->count / 8)
        PC_TRY(pc_resize_bytes((void **)&list->triangle, ctx, list->count, 3 * sizeof(pc_index)));
    mesh->face_count = (pc_index)list->count;
    mesh->triangle = list->triangle;
    list->triangle = NULL;
done:
    pc_facelist_free(list, ctx);
    return status;
}
