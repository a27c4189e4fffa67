/* Pictures: what is seen where, the same for any number of threads, and nothing that upsets them. */
#include "camera.h"
#include "lettering.h"
#include "picture.h"
#include "polymesh.h"
#include "random.h"
#include "raster.h"
#include "scatter.h"
#include "scene.h"
#include "stroke.h"
#include "surface.h"
#include "synth.h"
#include "testing.h"
#include "transition.h"
#include <omp.h>

static const pc_picture_options small = {
    .width = 160, .height = 120, .samples = 2, .view = PC_VIEW_FRONT, .up = PC_UP_Y};

static int differs_from_background(const uint8_t *pixel) {
    return pixel[0] < 225 || pixel[1] < 225 || pixel[2] < 225;
}

static const uint8_t *pixel_of(const pc_picture *picture, const uint8_t *pixels, pc_vec3 p) {
    float s[3];
    pc_camera_project(s, &picture->pane[0].camera, p);
    int x = (int)(s[0] / (float)picture->samples), y = (int)(s[1] / (float)picture->samples);
    assert_in_range(x, 0, picture->width - 1);
    assert_in_range(y, 0, picture->height - 1);
    return pixels + 3 * ((size_t)y * (size_t)picture->width + (size_t)x);
}

/* A large triangle at z = 0 and a small one before it. */
static const double two_positions[18] = {0, 0, 0, 4, 0, 0, 0, 3, 0, 0.5, 0.5, 1, 1.5, 0.5, 1, 0.5, 1.5, 1};
static const pc_index two_faces[6] = {0, 1, 2, 3, 4, 5};

static void nearer_triangle_hides_the_other(void **state) {
    pc_context *ctx = *state;
    for (int order = 0; order < 2; order++) {
        pc_picture picture;
        uint8_t *pixels = NULL;
        pc_index faces[6];
        pc_color color[2];
        for (int i = 0; i < 6; i++)
            faces[i] = two_faces[order ? (i + 3) % 6 : i];
        color[order] = 0xff0000, color[1 - order] = 0x0000ff;
        assert_ok(ctx, pc_picture_make(&picture, ctx, two_positions, 6, &small));
        pc_surface s = pc_surface_of(two_positions, 6, faces, 2);
        s.face_color = color;
        assert_ok(ctx, pc_surface_draw(&picture, ctx, &s));
        assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
        const uint8_t *near = pixel_of(&picture, pixels, (pc_vec3){0.8, 0.8, 1});
        const uint8_t *far = pixel_of(&picture, pixels, (pc_vec3){2.2, 0.8, 0});
        const uint8_t *none = pixel_of(&picture, pixels, (pc_vec3){3.5, 2.5, 0});
        assert_true(near[2] > 100 && near[0] < 60);
        assert_true(far[0] > 100 && far[2] < 60);
        assert_false(differs_from_background(none));
        pc_free(ctx, pixels);
        pc_picture_free(&picture, ctx);
    }
}

/* Every sample whose middle lies inside a closed grid of random points is covered: neighbours leave no gap.
 */
static void neighbours_leave_no_gap(void **state) {
    pc_context *ctx = *state;
    pc_random random = {7};
    for (int round = 0; round < 20; round++) {
        pc_mesh mesh;
        pc_picture picture;
        pc_picture_options options = small;
        if (round & 1)
            options.width = 600, options.height = 800; /* triangles of more than 500 samples, too */
        assert_ok(ctx, round & 1 ? pc_synth_plane(&mesh, ctx, 1, 1, 4, 1)
                                 : pc_synth_plane(&mesh, ctx, 1, 1, 9, 7));
        for (size_t v = 0; v < mesh.vertex_count; v++)
            for (size_t k = 0; k < 2; k++) {
                double *p = &mesh.position[3 * v + k];
                if (*p > 0 && *p < 1) *p += 0.06 * (pc_random_uniform(&random) - 0.5);
            }
        assert_ok(ctx, pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
        assert_ok(ctx, pc_scene_scan(&picture, ctx, &mesh));
        float a[3], b[3];
        pc_camera_project(a, &picture.pane[0].camera, (pc_vec3){0, 1, 0});
        pc_camera_project(b, &picture.pane[0].camera, (pc_vec3){1, 0, 0});
        for (int y = (int)a[1] + 1; y < (int)b[1]; y++)
            for (int x = (int)a[0] + 1; x < (int)b[0]; x++)
                if (!isfinite(picture.depth[(size_t)y * (size_t)picture.columns + (size_t)x]))
                    fail_msg("round %d: sample %d %d is not covered", round, x, y);
        pc_picture_free(&picture, ctx);
        pc_mesh_free(&mesh, ctx);
    }
}

static int limited(int value, int end) {
    return value < 0 ? 0 : value < end ? value : end - 1;
}

/* A channel of a pixel, sample by sample: 3 for those inside, 1 for those around, along both directions. */
static int mixed_channel(const pc_picture *picture, int x, int y, int channel) {
    const int s = picture->samples, rim = s > 1, side = s > 1 ? 3 * s + 2 : 3, total = side * side;
    int sum = 0;
    for (int j = -rim; j < s + rim; j++)
        for (int i = -rim; i < s + rim; i++) {
            const int weight = (i < 0 || i >= s ? 1 : 3) * (j < 0 || j >= s ? 1 : 3);
            const size_t row = (size_t)limited(y * s + j, picture->rows);
            const size_t at = row * (size_t)picture->columns + (size_t)limited(x * s + i, picture->columns);
            sum += weight * pc_color_channel(picture->color[at], channel);
        }
    return (sum + total / 2) / total;
}

static void pixels_are_means_of_samples(void **state) {
    pc_context *ctx = *state;
    pc_random random = {11};
    for (int s = 1; s <= 4; s++) {
        pc_picture picture;
        uint8_t *pixels = NULL;
        const pc_picture_options options = {.width = 530, .height = 17, .samples = s, .view = PC_VIEW_FRONT};
        assert_ok(ctx, pc_picture_make(&picture, ctx, two_positions, 6, &options));
        for (int i = 0; i < picture.columns * picture.rows; i++) {
            const uint64_t value = pc_random_next(&random); /* many of them black or white: the extremes */
            picture.color[i] = value >> 40 & 1   ? (pc_color)(value & 0xffffff)
                               : value >> 41 & 1 ? 0xffffff
                                                 : 0;
        }
        assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
        for (int y = 0; y < picture.height; y++)
            for (int x = 0; x < picture.width; x++)
                for (int k = 0; k < 3; k++)
                    assert_int_equal(pixels[3 * (y * picture.width + x) + k],
                                     mixed_channel(&picture, x, y, k));
        pc_free(ctx, pixels);
        pc_picture_free(&picture, ctx);
    }
}

static void shrunk_pixels_keep_the_mean(void **state) {
    pc_context *ctx = *state;
    enum { WIDTH = 120, HEIGHT = 90, LESS = 73, LOW = 41 };
    static uint8_t pixels[3 * WIDTH * HEIGHT];
    pc_random random = {5};
    uint8_t *shrunk = NULL;
    double before = 0, after = 0;
    for (size_t i = 0; i < sizeof(pixels); i++)
        before += pixels[i] = (uint8_t)pc_random_next(&random);
    assert_ok(ctx, pc_picture_shrink(&shrunk, ctx, pixels, WIDTH, HEIGHT, LESS, LOW));
    for (size_t i = 0; i < 3 * LESS * LOW; i++)
        after += shrunk[i];
    assert_true(fabs(before / (WIDTH * HEIGHT) - after / (LESS * LOW)) < 0.1);
    pc_free(ctx, shrunk);
    memset(pixels, 255, sizeof(pixels));
    assert_ok(ctx, pc_picture_shrink(&shrunk, ctx, pixels, WIDTH, HEIGHT, LESS, LOW));
    for (size_t i = 0; i < 3 * LESS * LOW; i++)
        assert_int_equal(shrunk[i], 255);
    pc_free(ctx, shrunk);
}

/* Two faces side by side: pixels that both cover show the mean of their colors, however the light is shared.
 */
static void faces_keep_their_colors_within_a_pixel(void **state) {
    pc_context *ctx = *state;
    const double position[12] = {0, 0, 0, 2.013, 0, 0, 2.013, 3, 0, 0, 3, 0};
    const double both[18] = {0, 0, 0, 4, 0, 0, 0, 3, 0, 4, 3, 0, 2.013, 0, 0, 2.013, 3, 0};
    const pc_index faces[12] = {0, 4, 2, 4, 5, 2, 4, 1, 5, 1, 3, 5};
    const pc_color color[4] = {0xff0000, 0xff0000, 0x0000ff, 0x0000ff};
    pc_picture picture;
    uint8_t *pixels = NULL;
    assert_ok(ctx, pc_picture_make(&picture, ctx, both, 6, &small));
    pc_surface s = pc_surface_of(both, 6, faces, 4);
    s.face_color = color;
    assert_ok(ctx, pc_surface_draw(&picture, ctx, &s));
    for (int y = 0; y < picture.rows; y++)
        for (int x = 0; x < picture.columns; x++) {
            const size_t at = (size_t)y * (size_t)picture.columns + (size_t)x;
            if (!isfinite(picture.depth[at])) continue;
            const pc_color c = picture.color[at];
            const int red = pc_color_channel(c, 0), blue = pc_color_channel(c, 2);
            assert_true(red > blue + 100 || blue > red + 100); /* no sample has a mixture */
            const double column = picture.pane[0].camera.column;
            const double edge = column + picture.pane[0].camera.scale * (position[3] - 2);
            if (fabs(x + 0.5 - edge) > 0.01) assert_int_equal(red > blue, x + 0.5 < edge);
        }
    assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
    pc_free(ctx, pixels);
    pc_picture_free(&picture, ctx);
}

/* What was drawn before leaves no trace. */
static void cleared_pictures_are_as_new(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_picture one, other;
    uint8_t *pixels[2];
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 0.7, 60, 20));
    pc_picture_options options = small;
    options.width = 601, options.view = PC_VIEW_PAIR, options.legend = 1;
    assert_ok(ctx, pc_picture_make(&one, ctx, mesh.position, mesh.vertex_count, &options));
    assert_ok(ctx, pc_scene_scan(&one, ctx, &mesh));
    options.legend = 0;
    pc_picture_clear(&one, mesh.position, mesh.vertex_count, &options);
    assert_ok(ctx, pc_picture_make(&other, ctx, mesh.position, mesh.vertex_count, &options));
    for (int k = 0; k < 2; k++) {
        assert_ok(ctx, pc_scene_scan(k ? &other : &one, ctx, &mesh));
        assert_ok(ctx, pc_picture_pixels(&pixels[k], ctx, k ? &other : &one));
    }
    assert_memory_equal(pixels[0], pixels[1], 3 * 601 * 120);
    for (int k = 0; k < 2; k++)
        pc_free(ctx, pixels[k]);
    pc_picture_free(&one, ctx);
    pc_picture_free(&other, ctx);
    pc_mesh_free(&mesh, ctx);
}

static void line_behind_a_surface_is_hidden(void **state) {
    pc_context *ctx = *state;
    pc_picture picture;
    uint8_t *pixels = NULL;
    const pc_stroke strokes[2] = {
        {.from = {1, 0.2, -0.5},
         .to = {1, 2.0, -0.5},
         .color = 0,
         .width = 3}, /* behind the large triangle */
        {.from = {2.2, 0.2, 0.1}, .to = {2.2, 1.0, 0.1}, .color = 0, .width = 3} /* before it */
    };
    assert_ok(ctx, pc_picture_make(&picture, ctx, two_positions, 6, &small));
    pc_surface s = pc_surface_of(two_positions, 6, two_faces, 1);
    assert_ok(ctx, pc_surface_draw(&picture, ctx, &s));
    assert_ok(ctx, pc_stroke_draw(&picture, ctx, strokes, 2, 1e-3));
    assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
    assert_true(pixel_of(&picture, pixels, (pc_vec3){1, 1, -0.5})[0] > 120);
    assert_true(pixel_of(&picture, pixels, (pc_vec3){2.2, 0.6, 0.1})[0] < 60);
    pc_free(ctx, pixels);
    pc_picture_free(&picture, ctx);
}

static void line_on_a_surface_is_whole(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_picture picture;
    uint8_t *pixels = NULL;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 12));
    pc_picture_options options = small;
    options.width = options.height = 400;
    assert_ok(ctx, pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
    assert_ok(ctx, pc_scene_scan(&picture, ctx, &mesh));
    pc_stroke *stroke = NULL;
    assert_ok(ctx, pc_new(&stroke, ctx, 3 * (size_t)mesh.face_count));
    for (pc_index h = 0; h < 3 * mesh.face_count; h++) {
        pc_vec3_put(stroke[h].from, 0, pc_vec3_at(mesh.position, pc_tail(&mesh, h)));
        pc_vec3_put(stroke[h].to, 0, pc_vec3_at(mesh.position, pc_head(&mesh, h)));
        stroke[h].width = 1.5F;
    }
    assert_ok(ctx, pc_stroke_draw(&picture, ctx, stroke, 3 * (size_t)mesh.face_count, 2e-3));
    assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
    for (pc_index h = 0; h < 3 * mesh.face_count; h++)
        for (int k = 1; k < 8; k++) { /* along each edge that is clearly on the near side */
            pc_vec3 p = pc_vec3_at(stroke[h].from, 0), q = pc_vec3_at(stroke[h].to, 0);
            p = pc_madd(p, k / 8.0, pc_sub(q, p));
            const uint8_t *pixel = pixel_of(&picture, pixels, p);
            if (p.z > 0.4 && pixel[0] > 130) fail_msg("edge of half-edge %u is broken: %d", h, pixel[0]);
        }
    pc_free(ctx, stroke);
    pc_free(ctx, pixels);
    pc_picture_free(&picture, ctx);
    pc_mesh_free(&mesh, ctx);
}

static void views_look_where_they_say(void **state) {
    (void)state;
    const double box[6] = {0, 0, 0, 2, 3, 1};
    const pc_vec3 back[] = {{0, 0, 1}, {0, 0, -1}, {-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
    pc_vec3 up, front;
    pc_camera_guess(&up, &front, box, 2, PC_UP_Y);
    for (int k = 0; k < 6; k++) {
        pc_camera c;
        pc_camera_make(&c, (pc_view)(PC_VIEW_FRONT + k), up, front, box, 2);
        assert_true(pc_distance(c.back, back[k]) < 1e-12);
        assert_true(fabs(pc_dot(c.right, c.back)) < 1e-12 && fabs(pc_dot(c.up, c.back)) < 1e-12);
        assert_true(pc_distance(pc_cross(c.right, c.up), c.back) < 1e-12);
    }
}

/* A cone with a flat, finely meshed floor stands on it; a tall box without one stands up. */
static void models_stand_on_their_feet(void **state) {
    (void)state;
    double cone[300], box[24];
    pc_vec3 up, front;
    for (int axis = 1; axis < 3; axis++) {
        for (size_t i = 0; i < 100; i++) {
            double rise = i < 40 ? 0 : ((double)i - 39) / 60, angle = 2.4 * (double)i;
            cone[3 * i] = (1.1 - rise) * cos(angle);
            cone[3 * i + (size_t)axis] = rise;
            cone[3 * i + 3 - (size_t)axis] = 3 * (1.1 - rise) * sin(angle);
        }
        pc_camera_guess(&up, &front, cone, 100, PC_UP_AUTO);
        assert_true((axis == 1 ? up.y : up.z) > 0.99);
    }
    for (size_t i = 0; i < 8; i++)
        box[3 * i] = (double)(i & 1), box[3 * i + 1] = (double)(i >> 1 & 1),
                box[3 * i + 2] = 3.0 * (double)(i >> 2);
    pc_camera_guess(&up, &front, box, 8, PC_UP_AUTO);
    assert_true(up.z > 0.99);
}

static void model_fits_every_view(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 3, 1, 40, 20));
    for (size_t v = 0; v < mesh.vertex_count; v++)
        mesh.position[3 * v] = 1e6 + 0.01 * mesh.position[3 * v]; /* thin and far from the origin */
    for (int view = PC_VIEW_PAIR; view <= PC_VIEW_BOTTOM; view++) {
        pc_picture picture;
        pc_picture_options options = small;
        options.view = (pc_view)view, options.up = PC_UP_AUTO, options.width = 600, options.legend = 1;
        assert_ok(ctx, pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
        assert_int_equal(picture.pane_count, view == PC_VIEW_PAIR ? 2 : 1);
        for (int k = 0; k < picture.pane_count; k++)
            for (size_t v = 0; v < mesh.vertex_count; v++) {
                float s[3];
                const int *box = picture.pane[k].box;
                pc_camera_project(s, &picture.pane[k].camera, pc_vec3_at(mesh.position, v));
                assert_true(isfinite(s[2]));
                assert_true(s[0] > (float)box[0] && s[0] < (float)box[2]);
                assert_true(s[1] > (float)box[1] && s[1] < (float)box[3]);
            }
        pc_picture_free(&picture, ctx);
    }
    pc_mesh_free(&mesh, ctx);
}

/* A cross field around the y axis. */
static void make_field(pc_field *field, pc_context *ctx, const pc_mesh *mesh) {
    *field = (pc_field){.symmetry = 4, .vertex_count = mesh->vertex_count, .face_count = mesh->face_count};
    assert_ok(ctx, pc_new(&field->normal, ctx, 3 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&field->direction, ctx, 3 * (size_t)mesh->vertex_count));
    assert_ok(ctx, pc_new(&field->index, ctx, mesh->face_count));
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        pc_vec3 n = pc_unit(pc_vec3_at(mesh->position, i));
        pc_vec3_put(field->normal, i, n);
        pc_vec3_put(field->direction, i, pc_unit(pc_cross((pc_vec3){0, 1, 0}, n)));
    }
    field->index[3] = 1, field->index[9] = -2;
}

static void draw_everything(uint8_t **pixels, pc_context *ctx, const pc_mesh *mesh, const pc_field *field,
                            const pc_polymesh *quads) {
    pc_picture picture;
    double *value = NULL;
    pc_picture_options options = small;
    options.view = PC_VIEW_PAIR, options.legend = 1, options.width = 600;
    assert_ok(ctx, pc_new(&value, ctx, mesh->vertex_count));
    for (size_t v = 0; v < mesh->vertex_count; v++)
        value[v] = v % 7 ? mesh->position[3 * v] : NAN;
    assert_ok(ctx, pc_picture_make(&picture, ctx, mesh->position, mesh->vertex_count, &options));
    assert_ok(ctx, pc_scene_values(&picture, ctx, mesh, value, &pc_colormap_diverging, 0, 0, "x in mm"));
    assert_ok(ctx, pc_scene_field(&picture, ctx, mesh, field));
    assert_ok(ctx, pc_scene_quads(&picture, ctx, quads));
    assert_ok(ctx, pc_scene_caption(&picture, ctx, "All letters, \xc3\xa4 too: 0123456789 (%)"));
    assert_ok(ctx, pc_picture_pixels(pixels, ctx, &picture));
    pc_picture_free(&picture, ctx);
    pc_free(ctx, value);
}

/* Triangles, quads and pentagons, one with a T-junction. */
static void make_quads(pc_polymesh *quads, pc_context *ctx) {
    const double position[] = {-1,  -1, 1.2, 0,   -1, 1.2, 1,   -1, 1.2, -1, 0,
                               1.2, 0,  0,   1.2, 1,  0,   1.2, 0,  1,   1.2};
    const pc_index start[] = {0, 4, 8, 11, 15}, corner[] = {0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 6, 4, 5, 6, 6};
    assert_ok(ctx, pc_polymesh_make(quads, ctx, 7, 4, 15));
    memcpy(quads->position, position, sizeof(position));
    memcpy(quads->start, start, sizeof(start));
    memcpy(quads->corner, corner, sizeof(corner));
    quads->corner_flat[9] = 1;
}

static void threads_change_no_byte(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_field field;
    pc_polymesh quads;
    uint8_t *one = NULL, *many = NULL;
    int before = omp_get_max_threads();
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 20));
    make_field(&field, ctx, &mesh);
    make_quads(&quads, ctx);
    omp_set_num_threads(1);
    draw_everything(&one, ctx, &mesh, &field, &quads);
    omp_set_num_threads(5);
    draw_everything(&many, ctx, &mesh, &field, &quads);
    omp_set_num_threads(before);
    assert_memory_equal(one, many, 3 * 600 * 120);
    pc_free(ctx, one);
    pc_free(ctx, many);
    pc_polymesh_free(&quads, ctx);
    pc_field_free(&field, ctx);
    pc_mesh_free(&mesh, ctx);
}

/* Points at infinity, no faces, no extent, faces without area. */
static void degenerate_meshes_are_survived(void **state) {
    pc_context *ctx = *state;
    double position[15] = {0, 0, 0, 1, 0, 0, NAN, 1, 0, 1e300, 1, INFINITY, 0.5, 0, 0};
    pc_index faces[12] = {0, 1, 2, 0, 0, 1, 0, 1, 4, 1, 3, 2};
    for (int round = 0; round < 4; round++) {
        pc_picture picture;
        uint8_t *pixels = NULL;
        pc_index vertices = round == 1 ? 0 : round == 2 ? 1 : 5;
        pc_mesh mesh = {vertices, vertices == 5 ? 4 : 0, position, faces};
        pc_field field;
        double value[5] = {NAN, INFINITY, 0, 0, -INFINITY};
        if (round == 3)
            for (int i = 0; i < 15; i++)
                position[i] = NAN;
        make_field(&field, ctx, &(pc_mesh){5, 20, position, faces});
        field.face_count = mesh.face_count;
        assert_ok(ctx, pc_picture_make(&picture, ctx, position, vertices, &small));
        assert_ok(ctx, pc_scene_scan(&picture, ctx, &mesh));
        assert_ok(ctx, pc_scene_values(&picture, ctx, &mesh, value, &pc_colormap_sequential, 0, 0, ""));
        assert_ok(ctx, pc_scene_field(&picture, ctx, &mesh, &field));
        assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
        pc_free(ctx, pixels);
        pc_field_free(&field, ctx);
        pc_picture_free(&picture, ctx);
    }
}

static void sizes_out_of_reach_are_refused(void **state) {
    pc_context *ctx = *state;
    pc_picture picture;
    pc_picture_options options = small;
    options.width = 0;
    assert_int_equal(pc_picture_make(&picture, ctx, two_positions, 6, &options), PC_E_USAGE);
    options.width = 16000, options.samples = 4;
    assert_int_equal(pc_picture_make(&picture, ctx, two_positions, 6, &options), PC_E_USAGE);
    pc_view view;
    assert_ok(ctx, pc_view_parse(&view, ctx, "back-iso"));
    assert_int_equal(view, PC_VIEW_BACK_ISO);
    assert_int_equal(pc_view_parse(&view, ctx, "sideways"), PC_E_USAGE);
}

static void refused_memory_leaves_nothing_behind(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_field field;
    assert_ok(ctx, pc_synth_sphere(&mesh, ctx, 4));
    make_field(&field, ctx, &mesh);
    int finished = 0;
    for (size_t n = 1; n < 200 && !finished; n++) {
        pc_picture picture;
        pc_memory_fail_at(ctx, n);
        pc_status status = pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &small);
        if (status == PC_OK) status = pc_scene_scan(&picture, ctx, &mesh);
        if (status == PC_OK) status = pc_scene_field(&picture, ctx, &mesh, &field);
        if (status == PC_OK) status = pc_scene_caption(&picture, ctx, "text");
        pc_memory_fail_at(ctx, 0);
        assert_true(status == PC_OK || status == PC_E_NOMEM);
        finished = status == PC_OK;
        pc_picture_free(&picture, ctx);
        pc_context_clear_message(ctx);
    }
    assert_true(finished);
    pc_field_free(&field, ctx);
    pc_mesh_free(&mesh, ctx);
}

/* The iso-lines of a plane's own coordinates, each vertex in a frame turned and shifted at random: lines run
 * where x or y is a whole period, and nowhere else. */
static void isolines_do_not_depend_on_the_frames(void **state) {
    pc_context *ctx = *state;
    enum { NX = 24, NY = 18 };
    pc_mesh mesh;
    pc_param param = {0};
    pc_picture picture;
    uint8_t *pixels = NULL;
    int64_t whole[2 * (NX + 1) * (NY + 1)];
    pc_transition frame[(NX + 1) * (NY + 1)]; /* from the plane's coordinates to the vertex' own */
    pc_random random = {3};
    assert_ok(ctx, pc_synth_plane(&mesh, ctx, 4, 3, NX, NY));
    param.vertex_count = mesh.vertex_count, param.face_count = mesh.face_count, param.period_length = 1;
    assert_ok(ctx, pc_new(&param.coordinate, ctx, 2 * (size_t)mesh.vertex_count));
    assert_ok(ctx, pc_new(&param.turn, ctx, 3 * (size_t)mesh.face_count));
    assert_ok(ctx, pc_new(&param.shift, ctx, 6 * (size_t)mesh.face_count));
    assert_ok(ctx, pc_new(&param.singular, ctx, mesh.face_count));
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        for (size_t c = 0; c < 2; c++) /* lines at 0.5, 1.5, ... of the plane */
            whole[2 * v + c] = (int64_t)((mesh.position[3 * v + c] - 0.5) * PC_PERIOD) | 1;
        frame[v] =
            (pc_transition){(int)(pc_random_next(&random) & 3), (int64_t)(pc_random_next(&random) % 9) - 4,
                            (int64_t)(pc_random_next(&random) % 9) - 4};
        pc_point2 own = pc_transition_apply(frame[v], (pc_point2){whole[2 * v], whole[2 * v + 1]});
        param.coordinate[2 * v] = (int32_t)own.s, param.coordinate[2 * v + 1] = (int32_t)own.t;
    }
    for (pc_index h = 0; h < 3 * mesh.face_count; h++) {
        pc_transition g =
            pc_transition_after(frame[pc_tail(&mesh, h)], pc_transition_inverse(frame[pc_head(&mesh, h)]));
        param.turn[h] = (uint8_t)g.turn;
        param.shift[2 * (size_t)h] = (int32_t)g.a, param.shift[2 * (size_t)h + 1] = (int32_t)g.b;
    }
    pc_picture_options options = small;
    options.width = 400, options.height = 300;
    assert_ok(ctx, pc_picture_make(&picture, ctx, mesh.position, mesh.vertex_count, &options));
    assert_ok(ctx, pc_scene_param(&picture, ctx, &mesh, &param));
    assert_ok(ctx, pc_picture_pixels(&pixels, ctx, &picture));
    for (int j = 0; j < 6; j++)
        for (int i = 0; i < 8; i++) {
            double x = 0.25 + 0.5 * i, y = 0.25 + 0.5 * j, on = floor(x) + 0.5;
            assert_true(pixel_of(&picture, pixels, (pc_vec3){x, y, 0})[0] > 150);
            assert_true(pixel_of(&picture, pixels, (pc_vec3){on, y, 0})[0] < 110);
            assert_true(pixel_of(&picture, pixels, (pc_vec3){x, floor(y) + 0.5, 0})[0] < 110);
        }
    pc_free(ctx, pixels);
    pc_picture_free(&picture, ctx);
    pc_param_free(&param, ctx);
    pc_mesh_free(&mesh, ctx);
}

static void scattered_points_keep_their_distance(void **state) {
    pc_context *ctx = *state;
    pc_mesh mesh;
    pc_scatter scatter;
    const double spacing = 0.15;
    assert_ok(ctx, pc_synth_torus(&mesh, ctx, 2, 0.7, 90, 17)); /* unevenly long triangles */
    assert_ok(ctx, pc_scatter_make(&scatter, ctx, &mesh, spacing));
    pc_vec3 *p = NULL;
    assert_ok(ctx, pc_new(&p, ctx, scatter.count));
    for (size_t i = 0; i < scatter.count; i++)
        for (size_t k = 0; k < 3; k++)
            p[i] = pc_madd(p[i], scatter.weight[3 * i + k],
                           pc_vec3_at(mesh.position, mesh.triangle[3 * (size_t)scatter.face[i] + k]));
    for (size_t i = 0; i < scatter.count; i++)
        for (size_t j = 0; j < i; j++)
            assert_true(pc_distance(p[i], p[j]) > spacing * (1 - 1e-6));
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        double nearest = INFINITY;
        for (size_t i = 0; i < scatter.count; i++)
            nearest = fmin(nearest, pc_distance(p[i], pc_vec3_at(mesh.position, v)));
        if (nearest > 1.8 * spacing) fail_msg("no point within %g of vertex %zu", nearest, v);
    }
    pc_free(ctx, p);
    pc_scatter_free(&scatter, ctx);
    pc_mesh_free(&mesh, ctx);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nearer_triangle_hides_the_other, make_context, free_context),
        cmocka_unit_test_setup_teardown(neighbours_leave_no_gap, make_context, free_context),
        cmocka_unit_test_setup_teardown(pixels_are_means_of_samples, make_context, free_context),
        cmocka_unit_test_setup_teardown(shrunk_pixels_keep_the_mean, make_context, free_context),
        cmocka_unit_test_setup_teardown(faces_keep_their_colors_within_a_pixel, make_context, free_context),
        cmocka_unit_test_setup_teardown(cleared_pictures_are_as_new, make_context, free_context),
        cmocka_unit_test_setup_teardown(line_behind_a_surface_is_hidden, make_context, free_context),
        cmocka_unit_test_setup_teardown(line_on_a_surface_is_whole, make_context, free_context),
        cmocka_unit_test_setup_teardown(views_look_where_they_say, make_context, free_context),
        cmocka_unit_test_setup_teardown(models_stand_on_their_feet, make_context, free_context),
        cmocka_unit_test_setup_teardown(model_fits_every_view, make_context, free_context),
        cmocka_unit_test_setup_teardown(threads_change_no_byte, make_context, free_context),
        cmocka_unit_test_setup_teardown(degenerate_meshes_are_survived, make_context, free_context),
        cmocka_unit_test_setup_teardown(sizes_out_of_reach_are_refused, make_context, free_context),
        cmocka_unit_test_setup_teardown(refused_memory_leaves_nothing_behind, make_context, free_context),
        cmocka_unit_test_setup_teardown(isolines_do_not_depend_on_the_frames, make_context, free_context),
        cmocka_unit_test_setup_teardown(scattered_points_keep_their_distance, make_context, free_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
