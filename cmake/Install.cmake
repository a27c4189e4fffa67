# The program, its man page, the library with its headers, and what find_package(percale) needs.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
include(cmake/PublicHeaders.cmake)

install(TARGETS percale_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS percale EXPORT percaleTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT percaleTargets NAMESPACE percale:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/percale)

percale_public_headers(headers)
install(FILES ${headers} ${CMAKE_CURRENT_SOURCE_DIR}/host/include/percale/percale.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/percale)

configure_package_config_file(cmake/percaleConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/percaleConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/percale)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/percaleConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/percaleConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/percaleConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/percale)

# For programs that do not use CMake. The libraries are those that this build found.
set(pc_libraries ${OpenCL_LIBRARIES} ${PNG_LIBRARIES} ${ZLIB_LIBRARIES} ${HDF5_LIBRARIES} ${METIS_LIBRARY} ${DEFLATE_LIBRARY})
list(REMOVE_DUPLICATES pc_libraries)
list(JOIN pc_libraries " " PC_LIBRARIES)
file(RELATIVE_PATH PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" PC_PREFIX ${PC_PREFIX})
configure_file(cmake/percale.pc.in ${CMAKE_CURRENT_BINARY_DIR}/percale.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/percale.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

find_program(SCDOC scdoc)
if(SCDOC)
  set(man_source ${CMAKE_CURRENT_SOURCE_DIR}/docs/percale.1.scd)
  set(man_page ${CMAKE_CURRENT_BINARY_DIR}/percale.1)
  add_custom_command(OUTPUT ${man_page} COMMAND sh -c "${SCDOC} <${man_source} >${man_page}" DEPENDS ${man_source}
                     VERBATIM)
  add_custom_target(percale_man ALL DEPENDS ${man_page})
  install(FILES ${man_page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()
