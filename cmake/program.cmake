# The programs: the only targets that see both app and ui. `skein-bench` is one of its own, so that `skein` links no benchmarks.
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

# The commit is looked up in every build and known to the programs' main files alone: nothing else is compiled anew for it.
set(SKEIN_COMMIT_FOLDER ${CMAKE_BINARY_DIR}/commit)
add_custom_target(skein_commit BYPRODUCTS ${SKEIN_COMMIT_FOLDER}/commit.h
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DHEADER=${SKEIN_COMMIT_FOLDER}/commit.h
    -P ${PROJECT_SOURCE_DIR}/cmake/commit.cmake
  COMMENT "Looking up the commit" VERBATIM)

# skein_program(NAME MAIN app-room ui-room)
function(skein_program name main app_room ui_room)
  add_executable(${name} ${main} $<TARGET_OBJECTS:skein_sanitizers>)
  add_dependencies(${name} skein_commit)
  target_include_directories(${name} PRIVATE ${SKEIN_COMMIT_FOLDER})
  target_link_libraries(${name} PRIVATE ${app_room})
  if(SKEIN_GUI)
    target_link_libraries(${name} PRIVATE ${ui_room})
    target_compile_definitions(${name} PRIVATE SKEIN_GUI)
  endif()
endfunction()
skein_program(skein app/program/main.cpp skein_app_cli skein_ui)
skein_program(skein-bench app/program/bench_main.cpp skein_app_bench skein_ui_bench)
