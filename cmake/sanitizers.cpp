// What the ThreadSanitizer must not report: libraries that are not built for it, whose own synchronisation it cannot
// see. Our code between them stays checked. An object library, since the sanitizer's runtime looks the function up when
// the program starts.
#if defined(__SANITIZE_THREAD__)
extern "C" const char* __tsan_default_options();
extern "C" const char* __tsan_default_options() {
  return "die_after_fork=0";  // QProcess starts programs from windows that have threads
}
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race:dl_deallocate_tls\n"  // the loader frees what threads of TBB kept for themselves
         "race:libavcodec.so\n"
         "race:libavutil.so\n"
         "race:libavformat.so\n"
         "race:libswscale.so\n"
         "race:libopencv_\n"
         "race:libtbb.so\n"
         "deadlock:libgdal.so\n"
         "called_from_lib:libQt6Core.so\n"
         "called_from_lib:libQt6Gui.so\n"
         "called_from_lib:libQt6Widgets.so\n"
         "race:libQt6\n"
         "mutex:libQt6\n"
         "race:libxcb.so\n"
         "race:libX11.so\n"
         "race:libdbus-1.so\n"
         "race:libfontconfig.so\n"
         "race:libglib-2.0.so\n";
}
#endif

#if defined(__SANITIZE_ADDRESS__)
// GCC 12 takes what stands before the variables of a thread in a library that was loaded later for their size, which
// glibc 2.36 does not write there: by chance the leak checker then reads far beyond, and crashes when a program ends.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "intercept_tls_get_addr=0";
}
// What fontconfig keeps to the end of the program, behind cairo and Qt.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libfontconfig.so\n";
}
#endif
