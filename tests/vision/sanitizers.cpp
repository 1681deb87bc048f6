// Codecs and GDAL, which OpenCV brings along, are not built for ThreadSanitizer: it does not see how they synchronise.
#if defined(__SANITIZE_THREAD__)
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race:libavcodec.so\n"
         "race:libavutil.so\n"
         "race:libavformat.so\n"
         "race:libswscale.so\n"
         "race:libopencv_\n"
         "race:libtbb.so\n"
         "deadlock:libgdal.so\n";
}
#endif
