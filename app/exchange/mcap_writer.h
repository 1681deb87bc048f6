#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace skein::app {

/// Writes an MCAP file (https://mcap.dev/spec) of JSON messages: chunks, with an index, statistics and checksums, so
/// that a reader can seek in it. Fetch the bytes with take() between calls, and after finish().
class McapWriter {
 public:
  using Channel = std::uint16_t;

  /// `compressed`: chunks by zstd, which every common reader of MCAP supports.
  explicit McapWriter(bool compressed);

  /// A topic whose messages are JSON objects. `schema`: its name and a JSON schema.
  Channel add_channel(std::string_view topic, std::string_view schema_name, std::string_view schema);
  /// `time` [ns since the epoch of the file].
  void message(Channel channel, std::uint64_t time, std::string_view json);
  /// Attaches a complete file.
  void attach(std::string_view name, std::string_view media_type, std::string_view data);
  void metadata(std::string_view name, const std::map<std::string, std::string>& values);
  void finish();

  /// The bytes written since the last call.
  std::string take();

 private:
  struct Chunk {
    std::uint64_t begin, end, offset, length, index_length, packed_size, size;
    std::map<Channel, std::uint64_t> index_offsets;
  };
  struct Indexed {
    std::uint8_t opcode;  // of the index record in the summary
    std::string content;
  };
  std::uint64_t position() const noexcept { return taken_ + out_.size(); }
  void write(std::uint8_t opcode, std::string_view content);
  void close_chunk();

  bool compressed_;
  std::string out_, chunk_, schemas_, channels_;  // the last two: records, once more for the summary
  std::uint64_t taken_ = 0;
  std::uint64_t chunk_begin_ = 0, chunk_end_ = 0;
  std::map<Channel, std::vector<std::pair<std::uint64_t, std::uint64_t>>> chunk_index_;  // time, offset in the chunk
  std::vector<Chunk> chunks_;
  std::vector<Indexed> indexed_;
  std::vector<std::uint64_t> counts_;  // messages of each channel, which are numbered from 0
  std::uint64_t first_ = 0, last_ = 0;
  std::uint32_t attachments_ = 0, metadata_ = 0;
};

}  // namespace skein::app
