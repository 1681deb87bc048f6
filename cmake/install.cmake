# What is installed, and the Debian packages that cpack makes of it: scripts/package. Programs find everything relative to themselves.
include(CMakePackageConfigHelpers)
set(SKEIN_LIB lib)
if(CMAKE_LIBRARY_ARCHITECTURE)
  set(SKEIN_LIB lib/${CMAKE_LIBRARY_ARCHITECTURE})
endif()
set(SKEIN_DOC share/doc)

# --- skein: the program, its modules, what it comes with ---
install(TARGETS skein RUNTIME DESTINATION bin COMPONENT skein)
install(TARGETS skein_media skein_boards skein_aravis LIBRARY DESTINATION lib/skein/modules COMPONENT skein)
install(DIRECTORY resources/experiments resources/python resources/studies resources/cameras resources/figures resources/robots DESTINATION share/skein
  COMPONENT skein PATTERN __pycache__ EXCLUDE)
install(FILES resources/experiment.schema.json DESTINATION share/skein COMPONENT skein)
install(PROGRAMS resources/slurm/sweep.sbatch DESTINATION share/skein/slurm COMPONENT skein)
install(FILES README.md CHANGELOG.md CONVENTIONS.md ARCHITECTURE.md CONTRIBUTING.md CITATION.cff DESTINATION ${SKEIN_DOC}/skein COMPONENT skein)
install(DIRECTORY docs DESTINATION ${SKEIN_DOC}/skein COMPONENT skein)
# Documents name files of resources by their places in a checkout.
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/debian)
file(CREATE_LINK ../../skein ${CMAKE_BINARY_DIR}/debian/resources SYMBOLIC)
install(FILES ${CMAKE_BINARY_DIR}/debian/resources DESTINATION ${SKEIN_DOC}/skein COMPONENT skein)
install(FILES resources/desktop/org.skein_lab.skein.desktop DESTINATION share/applications COMPONENT skein)
install(FILES resources/desktop/org.skein_lab.skein.metainfo.xml DESTINATION share/metainfo COMPONENT skein)
install(FILES resources/desktop/skein.xml DESTINATION share/mime/packages COMPONENT skein)
install(FILES resources/icons/skein.svg DESTINATION share/icons/hicolor/scalable/apps COMPONENT skein)
install(FILES resources/completion/skein.bash DESTINATION share/bash-completion/completions RENAME skein COMPONENT skein)
install(FILES resources/completion/skein.zsh DESTINATION share/zsh/vendor-completions RENAME _skein COMPONENT skein)

# --- skein-bench ---
install(TARGETS skein-bench RUNTIME DESTINATION bin COMPONENT skein-bench)
install(FILES resources/completion/skein.bash DESTINATION share/bash-completion/completions RENAME skein-bench COMPONENT skein-bench)

# --- the manual, made of the programs' own words ---
find_program(SKEIN_GZIP gzip REQUIRED)
set(manual ${CMAKE_BINARY_DIR}/manual)
add_custom_command(OUTPUT ${manual}/made DEPENDS skein skein-bench
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual}
  COMMAND skein manual ${manual}/skein
  COMMAND skein-bench --manual ${manual}/skein-bench
  COMMAND ${SKEIN_GZIP} -9 -n -r ${manual}
  COMMAND ${CMAKE_COMMAND} -E touch ${manual}/made
  COMMENT "Writing the manual" VERBATIM)
add_custom_target(skein_manual ALL DEPENDS ${manual}/made)
install(DIRECTORY ${manual}/skein/ DESTINATION share/man/man1 COMPONENT skein)
install(DIRECTORY ${manual}/skein-bench/ DESTINATION share/man/man1 COMPONENT skein-bench)

# --- skein-dev: core for other programs, find_package(skein) -> skein::core ---
set_target_properties(skein_core PROPERTIES EXPORT_NAME core)
target_include_directories(skein_core PUBLIC $<INSTALL_INTERFACE:include/skein>)
target_compile_features(skein_core PUBLIC $<INSTALL_INTERFACE:cxx_std_20>)
install(TARGETS skein_core EXPORT skein ARCHIVE DESTINATION ${SKEIN_LIB} COMPONENT skein-dev)
install(EXPORT skein FILE skein-targets.cmake NAMESPACE skein:: DESTINATION ${SKEIN_LIB}/cmake/skein COMPONENT skein-dev)
configure_package_config_file(cmake/skein-config.cmake.in ${CMAKE_BINARY_DIR}/skein-config.cmake
  INSTALL_DESTINATION ${SKEIN_LIB}/cmake/skein)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/skein-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/skein-config.cmake ${CMAKE_BINARY_DIR}/skein-config-version.cmake
  DESTINATION ${SKEIN_LIB}/cmake/skein COMPONENT skein-dev)
install(DIRECTORY core DESTINATION include/skein COMPONENT skein-dev FILES_MATCHING PATTERN "*.h")
install(FILES app/controllers/skein_controller.h DESTINATION include COMPONENT skein-dev)
install(DIRECTORY docs/examples/core-library DESTINATION ${SKEIN_DOC}/skein-dev/examples COMPONENT skein-dev)

# --- python3-skein ---
set(packages skein skein-bench skein-dev skein-permissions)
if(EXISTS ${PROJECT_SOURCE_DIR}/resources/python/skein)
  install(DIRECTORY resources/python/skein DESTINATION lib/python3/dist-packages COMPONENT python3-skein
    PATTERN "__pycache__" EXCLUDE PATTERN "*test*" EXCLUDE)
  list(APPEND packages python3-skein)
endif()

# --- skein-permissions: what an administrator decides; nothing of it is in the other packages ---
install(FILES resources/debian/60-skein.rules DESTINATION lib/udev/rules.d COMPONENT skein-permissions)
install(FILES resources/debian/60-skein.conf DESTINATION /etc/security/limits.d COMPONENT skein-permissions)
install(FILES resources/debian/60-skein-sysctl.conf DESTINATION lib/sysctl.d RENAME 60-skein.conf COMPONENT skein-permissions)
install(FILES resources/debian/README.permissions DESTINATION ${SKEIN_DOC}/skein-permissions RENAME README.Debian
  COMPONENT skein-permissions)

# --- Debian's own files of every package ---
execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%aD OUTPUT_VARIABLE SKEIN_DATE
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT SKEIN_DATE)
  string(TIMESTAMP SKEIN_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()
# A package of a later commit is a later version: over one of the same version apt installs nothing, without a word.
execute_process(COMMAND ${CMAKE_COMMAND} -E env TZ=UTC git -C ${PROJECT_SOURCE_DIR} log -1 --format=%cd
  --date=format-local:+git%Y%m%d%H%M%S OUTPUT_VARIABLE SKEIN_OF_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
set(SKEIN_PACKAGE_VERSION ${PROJECT_VERSION}${SKEIN_OF_COMMIT})
set(SKEIN_MAINTAINER "Skein maintainers <maintainers@skein.invalid>" CACHE STRING "Who answers for the packages: Name <address>")
configure_file(resources/debian/changelog.in ${CMAKE_BINARY_DIR}/debian/changelog @ONLY)
configure_file(resources/debian/copyright.in ${CMAKE_BINARY_DIR}/debian/copyright @ONLY)
execute_process(COMMAND ${SKEIN_GZIP} -9 -n -k -f ${CMAKE_BINARY_DIR}/debian/changelog COMMAND_ERROR_IS_FATAL ANY)
foreach(package ${packages})
  install(FILES ${CMAKE_BINARY_DIR}/debian/changelog.gz ${CMAKE_BINARY_DIR}/debian/copyright
    DESTINATION ${SKEIN_DOC}/${package} COMPONENT ${package})
endforeach()

# --- cpack -G DEB ---
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME skein)
set(CPACK_PACKAGE_VENDOR Skein)
set(CPACK_PACKAGE_VERSION ${SKEIN_PACKAGE_VERSION})
set(CPACK_PACKAGE_CONTACT "${SKEIN_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # every package has its own
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
  WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL ${packages})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

# skein_debian(PACKAGE SECTION "one line" "more lines" [DEPENDS ...] [RECOMMENDS ...] [SUGGESTS ...] [ARCHITECTURE all])
macro(skein_debian package section summary words)
  cmake_parse_arguments(PACKAGE "" "DEPENDS;RECOMMENDS;SUGGESTS;ARCHITECTURE" "" ${ARGN})
  string(TOUPPER ${package} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${summary}\n${words}")
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${summary}\n${words}")
  foreach(field DEPENDS RECOMMENDS SUGGESTS ARCHITECTURE)
    if(PACKAGE_${field})
      set(CPACK_DEBIAN_${key}_PACKAGE_${field} "${PACKAGE_${field}}")
    endif()
  endforeach()
endmacro()
set(exactly "(= ${SKEIN_PACKAGE_VERSION})")
skein_debian(skein science "real-time lab control for groups of unicycle robots"
  "An overhead camera sees tags on e-puck robots; a coordinated controller with\nmutual coupling and collision avoidance (Kostic, Adinandra, Caarls, Nijmeijer\n2010) keeps them in formation under hard actuator limits, over Bluetooth or\nWiFi. Experiments are files; they run in a window, without one, and simulated."
  RECOMMENDS "gnuplot-nox, fonts-dejavu-core, bluez, qt6-speech-speechd-plugin, speech-dispatcher" SUGGESTS "skein-permissions, skein-bench, xvfb")
set(CPACK_DEBIAN_SKEIN_PACKAGE_SHLIBDEPS ON)
skein_debian(skein-bench science "benchmarks of Skein on this machine"
  "Measures the control tick, the tag tracker, robots' links and the window of\nSkein, each as a ratio against a baseline of the same run."
  DEPENDS "skein ${exactly}" SUGGESTS xvfb)
set(CPACK_DEBIAN_SKEIN-BENCH_PACKAGE_SHLIBDEPS ON)
skein_debian(skein-dev libdevel "coordination of unicycle robots as a C++ library"
  "The science of Skein for other programs: references, the coordinated law,\navoidance, shield, planning, estimation and simulation of unicycle robots,\nas pure functions. A static library, its headers, and a package for CMake:\nfind_package(skein) gives skein::core."
  DEPENDS "libeigen3-dev (>= 3.4), libsleef-dev")
skein_debian(skein-permissions admin "real-time priority and devices for users of Skein"
  "Makes the group skein, lets its members use real-time priority up to 25\n(/etc/security/limits.d/60-skein.conf), gives whoever sits at the machine its\nBluetooth serial lines and e-pucks on USB, and keeps ModemManager away from\nthem (udev rules). Programs may ask the kernel for larger receive buffers, for\nGigE cameras (sysctl net.core.rmem_max). It adds nobody to the group."
  DEPENDS "adduser, udev" RECOMMENDS procps ARCHITECTURE all)
set(CPACK_DEBIAN_SKEIN-PERMISSIONS_PACKAGE_CONTROL_EXTRA
  "${PROJECT_SOURCE_DIR}/resources/debian/postinst;${PROJECT_SOURCE_DIR}/resources/debian/conffiles")
skein_debian(python3-skein python "Skein's experiments, runs and sweeps from Python"
  "Starts runs and sweeps of Skein and reads their records from a notebook or a\nscript, by the same engine as the command line."
  DEPENDS "skein (>= ${SKEIN_PACKAGE_VERSION}), python3:any" RECOMMENDS "python3-numpy, python3-matplotlib" ARCHITECTURE all)
include(CPack)
