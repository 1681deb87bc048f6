#include "app/run/exit_status.h"

#include <cstring>
#include <exception>
#include <new>
#include <string>

#include "app/run/output.h"
#include "app/run/output_error.h"

namespace skein::app {

int exit_status_of(const std::function<int()>& program) noexcept {
  fill_standard_descriptors();
  try {
    const int status = program();
    const int error = output_error();
    if (error == 0) return status;
    complain(std::string("stdout: cannot be written: ") + std::strerror(error));
    return status == done ? static_cast<int>(device_failed) : status;
  } catch (const std::bad_alloc&) {
    complain("out of memory");
  } catch (const std::exception& error) {
    complain(error.what());
  } catch (...) {
    complain("an unknown error");
  }
  return device_failed;
}

}  // namespace skein::app
