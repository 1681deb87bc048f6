#include "app/exchange/mcap_writer.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace skein::app {
namespace {

constexpr std::string_view magic{"\x89MCAP0\r\n", 8};
constexpr std::size_t chunk_size = std::size_t{1} << 20;  // [bytes] a reader that jumps reads one whole chunk

enum Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema_record = 0x03,
  channel_record = 0x04,
  message_record = 0x05,
  chunk_record = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata_record = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

std::uint32_t checksum(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

/// The fields of a record, little-endian, one after the other.
class Fields {
 public:
  template <typename Int>
  Fields& number(Int value) {
    for (std::size_t byte = 0; byte < sizeof(Int); ++byte)
      text_ += static_cast<char>(static_cast<unsigned char>(static_cast<std::uint64_t>(value) >> (8 * byte)));
    return *this;
  }
  Fields& u8(std::uint8_t value) { return number(value); }
  Fields& u16(std::uint16_t value) { return number(value); }
  Fields& u32(std::size_t value) { return number(static_cast<std::uint32_t>(value)); }
  Fields& u64(std::uint64_t value) { return number(value); }
  Fields& text(std::string_view value) { return u32(value.size()).raw(value); }
  Fields& raw(std::string_view value) {
    text_ += value;
    return *this;
  }
  Fields& map(const std::map<std::string, std::string>& values) {
    Fields entries;
    for (const auto& [key, value] : values) entries.text(key).text(value);
    return text(entries.str());
  }
  const std::string& str() const noexcept { return text_; }

 private:
  std::string text_;
};

std::string record(std::uint8_t opcode, std::string_view content) {
  return Fields().u8(opcode).u64(content.size()).raw(content).str();
}

std::string packed(const std::string& bytes) {
  std::string result(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(result.data(), result.size(), bytes.data(), bytes.size(), 3);
  if (ZSTD_isError(size)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  result.resize(size);
  return result;
}

}  // namespace

McapWriter::McapWriter(bool compressed) : compressed_(compressed) {
  out_ = magic;
  write(header, Fields().text("").text("skein " SKEIN_VERSION).str());
}

void McapWriter::write(std::uint8_t opcode, std::string_view content) {
  out_ += record(opcode, content);
}

McapWriter::Channel McapWriter::add_channel(std::string_view topic, std::string_view schema_name,
                                            std::string_view schema) {
  const auto channel = static_cast<Channel>(counts_.size());
  const auto schema_id = static_cast<std::uint16_t>(channel + 1);  // 0 means none
  counts_.push_back(0);
  const std::string of_schema =
      record(schema_record, Fields().u16(schema_id).text(schema_name).text("jsonschema").text(schema).str());
  const std::string of_channel =
      record(channel_record, Fields().u16(channel).u16(schema_id).text(topic).text("json").map({}).str());
  out_ += of_schema + of_channel;
  schemas_ += of_schema;
  channels_ += of_channel;
  return channel;
}

void McapWriter::message(Channel channel, std::uint64_t time, std::string_view json) {
  const bool first = std::all_of(counts_.begin(), counts_.end(), [](std::uint64_t n) { return n == 0; });
  first_ = first ? time : std::min(first_, time);
  last_ = first ? time : std::max(last_, time);
  chunk_begin_ = chunk_.empty() ? time : std::min(chunk_begin_, time);
  chunk_end_ = chunk_.empty() ? time : std::max(chunk_end_, time);
  chunk_index_[channel].emplace_back(time, chunk_.size());
  const auto sequence = static_cast<std::uint32_t>(counts_[channel]++);
  chunk_ += record(message_record, Fields().u16(channel).u32(sequence).u64(time).u64(time).raw(json).str());
  if (chunk_.size() >= chunk_size) close_chunk();
}

void McapWriter::close_chunk() {
  if (chunk_.empty()) return;
  const std::string bytes = compressed_ ? packed(chunk_) : std::string();
  const std::string& stored = compressed_ ? bytes : chunk_;
  Chunk chunk{chunk_begin_, chunk_end_, position(), 0, 0, stored.size(), chunk_.size(), {}};
  write(chunk_record, Fields()
                          .u64(chunk.begin)
                          .u64(chunk.end)
                          .u64(chunk_.size())
                          .u32(checksum(chunk_))
                          .text(compressed_ ? "zstd" : "")
                          .u64(stored.size())
                          .raw(stored)
                          .str());
  chunk.length = position() - chunk.offset;
  for (const auto& [channel, messages] : chunk_index_) {
    chunk.index_offsets[channel] = position();
    Fields entries;
    for (const auto& [time, offset] : messages) entries.u64(time).u64(offset);
    write(message_index, Fields().u16(channel).text(entries.str()).str());
  }
  chunk.index_length = position() - chunk.offset - chunk.length;
  chunks_.push_back(std::move(chunk));
  chunk_.clear();
  chunk_index_.clear();
}

void McapWriter::attach(std::string_view name, std::string_view media_type, std::string_view data) {
  close_chunk();
  const std::uint64_t offset = position();
  Fields content;
  content.u64(0).u64(0).text(name).text(media_type).u64(data.size()).raw(data);
  write(attachment, content.str() + Fields().u32(checksum(content.str())).str());
  ++attachments_;
  indexed_.push_back(
      {attachment_index,
       Fields().u64(offset).u64(position() - offset).u64(0).u64(0).u64(data.size()).text(name).text(media_type).str()});
}

void McapWriter::metadata(std::string_view name, const std::map<std::string, std::string>& values) {
  close_chunk();
  const std::uint64_t offset = position();
  write(metadata_record, Fields().text(name).map(values).str());
  ++metadata_;
  indexed_.push_back({metadata_index, Fields().u64(offset).u64(position() - offset).text(name).str()});
}

void McapWriter::finish() {
  close_chunk();
  write(data_end, Fields().u32(0).str());  // 0: no checksum of the whole; every chunk has its own

  const std::uint64_t summary_begin = position();
  std::string summary, offsets;
  // A group is a stretch of records of one kind.
  const auto group = [&](std::uint8_t opcode, const std::string& records) {
    if (records.empty()) return;
    offsets +=
        record(summary_offset, Fields().u8(opcode).u64(summary_begin + summary.size()).u64(records.size()).str());
    summary += records;
  };
  group(schema_record, schemas_);
  group(channel_record, channels_);
  Fields of_channels;
  for (std::size_t channel = 0; channel < counts_.size(); ++channel)
    of_channels.u16(static_cast<Channel>(channel)).u64(counts_[channel]);
  group(statistics, record(statistics, Fields()
                                           .u64(std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}))
                                           .u16(static_cast<std::uint16_t>(counts_.size()))
                                           .u32(counts_.size())
                                           .u32(attachments_)
                                           .u32(metadata_)
                                           .u32(chunks_.size())
                                           .u64(first_)
                                           .u64(last_)
                                           .text(of_channels.str())
                                           .str()));
  std::string indices;
  for (const Chunk& chunk : chunks_) {
    Fields index_offsets;
    for (const auto& [channel, offset] : chunk.index_offsets) index_offsets.u16(channel).u64(offset);
    indices += record(chunk_index, Fields()
                                       .u64(chunk.begin)
                                       .u64(chunk.end)
                                       .u64(chunk.offset)
                                       .u64(chunk.length)
                                       .text(index_offsets.str())
                                       .u64(chunk.index_length)
                                       .text(compressed_ ? "zstd" : "")
                                       .u64(chunk.packed_size)
                                       .u64(chunk.size)
                                       .str());
  }
  group(chunk_index, indices);
  for (const std::uint8_t opcode : {attachment_index, metadata_index}) {
    std::string records;
    for (const Indexed& one : indexed_)
      if (one.opcode == opcode) records += record(opcode, one.content);
    group(opcode, records);
  }

  // The checksum covers the summary, the offsets and the footer up to the checksum itself.
  const std::uint64_t offsets_begin = summary_begin + summary.size();
  const std::string rest =
      summary + offsets + Fields().u8(footer).u64(8 + 8 + 4).u64(summary_begin).u64(offsets_begin).str();
  out_ += rest + Fields().u32(checksum(rest)).str();
  out_ += magic;
}

std::string McapWriter::take() {
  taken_ += out_.size();
  return std::exchange(out_, {});
}

}  // namespace skein::app
