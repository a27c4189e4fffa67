/* Writes the seeds: fuzz_seeds FOLDER makes FOLDER/ply, obj, stl, off and scan. */
#include "scan_bytes.h"
#include <libdeflate.h>
#include <sys/stat.h>

static const char *root;
static int failed;

static void write_to(const char *reader, const char *name, const void *data, size_t size) {
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/%s", root, reader);
    (void)mkdir(path, 0777);
    (void)snprintf(path, sizeof path, "%s/%s/%s", root, reader, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size) failed = 1;
    if (file && fclose(file) != 0) failed = 1;
}

/* To the folder of its reader, and as it is and packed to that of the whole. */
static void seed(const char *reader, const char *name, scan_bytes *bytes) {
    char packed[8192];
    char packed_name[64];
    write_to(reader, name, bytes->data, bytes->size);
    write_to("scan", name, bytes->data, bytes->size);
    struct libdeflate_compressor *compressor = libdeflate_alloc_compressor(1);
    size_t size = compressor
                      ? libdeflate_gzip_compress(compressor, bytes->data, bytes->size, packed, sizeof packed)
                      : 0;
    libdeflate_free_compressor(compressor);
    (void)snprintf(packed_name, sizeof packed_name, "%s.gz", name);
    write_to("scan", packed_name, packed, size);
    bytes->size = 0;
}

static void seeds(void) {
    scan_bytes b = {.size = 0};
    make_ply_ascii(&b);
    seed("ply", "ascii", &b);
    make_ply_strips(&b, false);
    seed("ply", "strips", &b);
    for (int variant = 0; variant < 4; variant++) {
        static const char *const names[] = {"little", "big", "little_lists", "big_lists"};
        make_ply_binary(&b, variant & 1, variant & 2);
        seed("ply", names[variant], &b);
    }
    make_obj(&b);
    seed("obj", "habits", &b);
    make_obj_polygons(&b);
    seed("obj", "polygons", &b);
    make_off(&b);
    seed("off", "colours", &b);
    put_text(&b, "OFF 6 2 0\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n6 0 1 2 3 4 5\n4 0 1 3 5\n");
    seed("off", "polygons", &b);
    make_stl_ascii(&b);
    seed("stl", "ascii", &b);
    make_stl_binary(&b, "solid is what I say");
    seed("stl", "binary", &b);
}

int main(int argc, char **argv) {
    if (argc != 2) return 2;
    root = argv[1];
    (void)mkdir(root, 0777);
    seeds();
    return failed;
}
