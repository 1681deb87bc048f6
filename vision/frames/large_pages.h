#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>

namespace skein::vision {

/// Allocates what is as large as a picture in pages of 2 MB where the system has them (Linux: transparent huge pages).
/// The tracker's looks are scattered over a picture, every row of which is in a page of its own or two: in pages of 4
/// kB it has to find some hundred pages anew where other work came between two frames (`skein-bench vision`, "cold").
template <class T>
struct LargePages {
  using value_type = T;

  LargePages() = default;
  template <class Other>
  LargePages(const LargePages<Other>&) {}  // NOLINT(google-explicit-constructor): as the standard asks of allocators

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes < least) return static_cast<T*>(::operator new(bytes));
    const std::size_t whole = (bytes + page - 1) / page * page;
    void* const memory = ::operator new(whole, std::align_val_t{page});
    madvise(memory, whole, MADV_HUGEPAGE);  // where it is refused, all works as before
    return static_cast<T*>(memory);
  }

  void deallocate(T* memory, std::size_t count) {
    if (count * sizeof(T) < least)
      ::operator delete(memory);
    else
      ::operator delete(memory, std::align_val_t{page});
  }

  template <class Other>
  bool operator==(const LargePages<Other>&) const {
    return true;
  }

 private:
  static constexpr std::size_t page = std::size_t{1} << 21;
  static constexpr std::size_t least = page / 8;  // 640 x 480 have 300 kB
};

}  // namespace skein::vision
