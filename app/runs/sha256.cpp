#include "app/runs/sha256.h"

#include <fmt/format.h>
#include <nettle/sha2.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "app/experiment/text_file.h"

namespace skein::app {

namespace {

std::string digest_of(sha256_ctx& context) {
  std::array<uint8_t, SHA256_DIGEST_SIZE> digest;
  sha256_digest(&context, digest.size(), digest.data());
  std::string text;
  for (const uint8_t byte : digest) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace

tl::expected<std::string, std::string> sha256_of_file(const std::string& path) {
  if (const auto is_file = check_is_file(path); !is_file) return tl::unexpected(is_file.error());  // no FIFO, say
  std::ifstream file(path, std::ios::binary);
  if (!file) return tl::unexpected(fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
  sha256_ctx context;
  sha256_init(&context);
  std::array<char, 1 << 16> block;
  while (file.read(block.data(), block.size()), file.gcount() > 0)
    sha256_update(&context, static_cast<std::size_t>(file.gcount()), reinterpret_cast<const uint8_t*>(block.data()));
  if (file.bad()) return tl::unexpected(fmt::format("{}: cannot be read: {}", path, std::strerror(errno)));
  return digest_of(context);
}

std::string sha256_of_text(std::string_view text) {
  sha256_ctx context;
  sha256_init(&context);
  sha256_update(&context, text.size(), reinterpret_cast<const uint8_t*>(text.data()));
  return digest_of(context);
}

}  // namespace skein::app
