#!/usr/bin/env bash
# Installs into an empty folder and builds a C and a C++ program against what is there.
set -euo pipefail
build=$1
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
END
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
