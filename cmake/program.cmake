# The program: the one target that sees both app and ui.
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
add_executable(skein app/program/main.cpp $<TARGET_OBJECTS:skein_sanitizers>)
target_link_libraries(skein PRIVATE skein_app_cli)
if(SKEIN_GUI)
  target_link_libraries(skein PRIVATE skein_ui)
  target_compile_definitions(skein PRIVATE SKEIN_GUI)
endif()
install(TARGETS skein RUNTIME DESTINATION bin)
