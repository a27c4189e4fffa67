#!/usr/bin/env bash
# Installs into an empty folder and builds a C and a C++ program against what is there, and the example of the docs, with
# CMake and with pkg-config; that one is run.
set -euo pipefail
build=$1
here=$(cd "$(dirname "$0")" && pwd)
docs=$here/../../docs
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cmake --install "$build" --prefix "$folder/usr" >/dev/null
mkdir "$folder/user" && cd "$folder/user"
cat >CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES C CXX)
find_package(percale REQUIRED)
foreach(language c cpp)
  add_executable(user_${language} user.${language})
  target_link_libraries(user_${language} PRIVATE percale::percale)
endforeach()
add_executable(example example_spline.c)
target_link_libraries(example PRIVATE percale::percale)
END
cp "$docs/example_spline.c" .
diff <(sed -n '/^```c$/,/^```$/p' "$docs/library.md" | sed '1d;$d') example_spline.c
cat >user.c <<'END'
#include <percale/percale.h>
int main(void) {
    pc_context *ctx = pc_context_make();
    pc_mesh mesh;
    pc_scan_info info;
    const char *scan = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    if (pc_scan_read_bytes(&mesh, &info, ctx, "triangle.obj", scan, strlen(scan)) != PC_OK) return 1;
    int good = mesh.face_count == 1 && fabs(pc_geometry_area(&mesh) - 0.5) < 1e-12;
    pc_mesh_free(&mesh, ctx);
    pc_context_free(ctx);
    puts(pc_version());
    return !good;
}
END
cp user.c user.cpp
cmake -S . -B build -DCMAKE_PREFIX_PATH="$folder/usr" -DCMAKE_BUILD_TYPE=Debug >/dev/null
cmake --build build
[[ $(build/user_c) == $("$folder/usr/bin/percale" --version | cut -d ' ' -f 2) ]]
[[ $(build/user_cpp) == $(build/user_c) ]]

awk -v n=48 -v m=24 -f "$here/../cli/torus.awk" >torus.obj
build/example torus.obj out >seen
printf '0 0.5 0.5\n' | "$folder/usr/bin/percale" eval out --at - | tail -1 |
    awk -F, '{ printf "point   %.6f %.6f %.6f\nnormal  %.6f %.6f %.6f\nnearest %.6f %.6f %.6f, %.6f away\n",
                      $4, $5, $6, $7, $8, $9, $4, $5, $6, 0.01 }' >expected
diff expected seen

command -v pkg-config >/dev/null || exit 0
export PKG_CONFIG_PATH; PKG_CONFIG_PATH=$(dirname "$(find "$folder/usr" -name percale.pc)")
[[ $(pkg-config --modversion percale) == $(build/user_c) ]]
# shellcheck disable=SC2046
cc example_spline.c $(pkg-config --cflags --libs percale) -o example_pc
./example_pc torus.obj out | diff seen -
