// Films that Skein records: read back, everything is the same to the bit; and nothing ever holds the frames up.
#include "vision/recording/recorder.h"
#include "tests/files.h"

#include <bit>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <numbers>

#include "tests/vision/support.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/random.h"

namespace skein::vision {
namespace {

/// A frame like a sensor's: shades and noise; times of the kind that no container keeps.
Frame noisy_frame(int width, int height, std::int64_t index, detail::Random& random) {
  Frame frame;
  frame.resize(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      frame.row(v)[u] = static_cast<std::uint8_t>((u / 3 + v / 2 + static_cast<int>(random.below(9))) & 255);
  frame.index = index;
  frame.source = std::to_string(index);
  frame.captured_at = 12345.678 + std::numbers::pi / 70.0 * static_cast<double>(index);
  return frame;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// A film in memory whose writer can be held up and broken.
struct Bench {
  std::mutex mutex;
  std::condition_variable changed;
  bool held = false;
  int writing = 0;  // frames that have reached the writer
  std::string problem;
  std::vector<std::int64_t> written;
  void hold(bool on) {
    const std::lock_guard lock(mutex);
    held = on;
    changed.notify_all();
  }
  void wait_for_writing(int count) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return writing >= count; });
  }
};

class BenchFilm final : public FilmWriter {
 public:
  explicit BenchFilm(Bench& bench) : bench_(bench) {}
  std::string write(const Frame& frame) override {
    std::unique_lock lock(bench_.mutex);
    ++bench_.writing;
    bench_.changed.notify_all();
    bench_.changed.wait(lock, [&] { return !bench_.held; });
    if (bench_.problem.empty()) bench_.written.push_back(frame.index);
    return bench_.problem;
  }
  std::string finish() override { return {}; }

 private:
  Bench& bench_;
};

TEST(Recorder, EverythingComesBackToTheBit) {
  test::Folder folder;
  detail::Random random(5);
  const std::string path = folder.file("a film.mkv");
  std::vector<Frame> frames;
  for (const std::int64_t index : {0, 1, 2, 5, 6, 1000}) frames.push_back(noisy_frame(321, 243, index, random));
  frames[3].captured_at = frames[2].captured_at;  // whatever the times are
  frames[4].captured_at = -0.1;
  frames[5].captured_at = std::numeric_limits<double>::denorm_min();
  const FilmNotes notes{{"PROGRAM", "skein 1.2.3"}, {"CALIBRATION", "[camera]\nwidth = 321  # px, \"\xc3\xa4\"\n"}};
  {
    auto recorder = Recorder::open(path, notes, FilmCoding::lossless, 2);
    ASSERT_TRUE(recorder) << recorder.error();
    for (const Frame& frame : frames) (*recorder)->add(frame);
    const RecorderStatus status = (*recorder)->finish();
    EXPECT_EQ(status.written, 6);
    EXPECT_EQ(status.dropped, 0);
    EXPECT_EQ(status.problem, "");
    EXPECT_EQ((*recorder)->finish().written, 6) << "once is enough";
  }
  auto film = open_source("video:" + path);
  ASSERT_TRUE(film) << film.error();
  EXPECT_TRUE((*film)->recorded());
  for (const auto& [name, text] : notes) EXPECT_EQ((*film)->notes().at(name), text);
  Frame frame;
  for (const Frame& wanted : frames) {
    ASSERT_TRUE((*film)->read(frame).value());
    EXPECT_EQ(frame.grey, wanted.grey);
    EXPECT_TRUE(same_bits(frame.captured_at, wanted.captured_at));
    EXPECT_EQ(frame.index, wanted.index);
    EXPECT_EQ(frame.source, wanted.source);
  }
  EXPECT_FALSE((*film)->read(frame).value());
  EXPECT_TRUE((*film)->skipped().empty());
}

/// Times and numbers are exact whatever happens to the pixels, and a damaged packet takes no other time with it.
TEST(Recorder, ASmallFilmKeepsTimesToTheBitAndNoticesDamage) {
  test::Folder folder;
  detail::Random random(8);
  const std::string path = folder.file("small.mkv");
  std::vector<Frame> frames;
  for (std::int64_t i = 0; i < 60; ++i) frames.push_back(noisy_frame(320, 240, 3 * i, random));
  {
    auto recorder = Recorder::open(path, {}, FilmCoding::small);
    ASSERT_TRUE(recorder) << recorder.error();
    for (const Frame& frame : frames) (*recorder)->add(frame);
    const RecorderStatus status = (*recorder)->finish();
    ASSERT_EQ(status.problem, "");
    EXPECT_EQ(status.written, 60);
  }
  const auto read_all = [&] {
    auto film = open_source("video:" + path);
    EXPECT_TRUE(film) << film.error();
    EXPECT_TRUE((*film)->recorded());
    EXPECT_EQ((*film)->notes().at(coding_note), "small");
    std::vector<Frame> all;
    for (Frame frame; (*film)->read(frame).value();) all.push_back(frame);
    return std::pair{all, (*film)->skipped().size()};
  };
  const auto [whole, none] = read_all();
  ASSERT_EQ(whole.size(), 60u);
  EXPECT_EQ(none, 0u);
  bool changed = false;
  for (std::size_t k = 0; k < 60; ++k) {
    EXPECT_EQ(whole[k].index, frames[k].index);
    EXPECT_TRUE(same_bits(whole[k].captured_at, frames[k].captured_at));
    changed = changed || whole[k].grey != frames[k].grey;
  }
  EXPECT_TRUE(changed) << "a film with losses that has none";

  std::string bytes = test::read_file(path);
  for (std::size_t k = bytes.size() / 2; k < bytes.size() / 2 + 40; ++k) bytes[k] = static_cast<char>(bytes[k] ^ 0x5a);
  test::write_file(path, bytes);
  const auto [left, skipped] = read_all();
  EXPECT_LT(left.size(), 60u);
  EXPECT_GE(left.size(), 30u);
  EXPECT_GE(skipped, 1u);
  for (const Frame& frame : left) {
    const auto& same = whole[static_cast<std::size_t>(frame.index / 3)];
    EXPECT_EQ(frame.grey, same.grey) << "what is handed on is not damaged";
    EXPECT_EQ(frame.captured_at, same.captured_at);
  }
}

TEST(Recorder, AFilmThatBreaksOffLosesItsEndOnly) {
  test::Folder folder;
  detail::Random random(6);
  const std::string path = folder.file("film.mkv");
  {
    auto recorder = Recorder::open(path);
    ASSERT_TRUE(recorder) << recorder.error();
    for (std::int64_t i = 0; i < 40; ++i) {
      Frame frame = noisy_frame(160, 120, i, random);
      frame.captured_at = 0.2 * static_cast<double>(i);
      (*recorder)->add(frame);
    }
  }
  const std::string whole = test::read_file(path);
  test::write_file(path, whole.substr(0, whole.size() * 3 / 4));  // as after a power cut
  auto film = open_source("video:" + path);
  ASSERT_TRUE(film) << film.error();
  Frame frame;
  std::int64_t frames = 0;
  while ((*film)->read(frame).value()) EXPECT_EQ(frame.index, frames++);
  EXPECT_GE(frames, 24);
  EXPECT_LT(frames, 40);
}

TEST(Recorder, AFilmWhoseRestIsMissingSaysSo) {
  test::Folder folder;
  detail::Random random(9);
  const std::string path = folder.file("film.mkv");
  {
    auto recorder = Recorder::open(path);
    ASSERT_TRUE(recorder) << recorder.error();
    for (std::int64_t i = 0; i < 50; ++i) (*recorder)->add(noisy_frame(160, 120, i, random));
  }
  const auto missing = [&] {
    auto film = open_source("video:" + path);
    EXPECT_TRUE(film) << film.error();
    Frame frame;
    while ((*film)->read(frame).value()) {
    }
    return std::vector<std::string>((*film)->skipped().begin(), (*film)->skipped().end());
  };
  EXPECT_EQ(missing(), std::vector<std::string>());
  const std::string bytes = test::read_file(path);
  test::write_file(path, bytes.substr(0, bytes.size() * 6 / 10));  // a copy that broke off
  const std::vector<std::string> said = missing();
  ASSERT_FALSE(said.empty());
  EXPECT_NE(said.back().find("film.mkv: all behind "), std::string::npos) << said.back();
}

TEST(Recorder, DamagedFramesAreSkippedAndReported) {
  test::Folder folder;
  detail::Random random(7);
  const std::string path = folder.file("film.mkv");
  std::vector<Frame> frames;
  {
    auto recorder = Recorder::open(path);
    ASSERT_TRUE(recorder) << recorder.error();
    for (std::int64_t i = 0; i < 10; ++i) (*recorder)->add(frames.emplace_back(noisy_frame(160, 120, i, random)));
  }
  std::string bytes = test::read_file(path);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
  test::write_file(path, bytes);
  auto film = open_source("video:" + path);
  ASSERT_TRUE(film) << film.error();
  Frame frame;
  int whole = 0;
  while ((*film)->read(frame).value()) {
    ++whole;
    EXPECT_EQ(frame.grey, frames[static_cast<std::size_t>(frame.index)].grey) << frame.index;
  }
  EXPECT_EQ(whole, 9);
  ASSERT_EQ((*film)->skipped().size(), 1U);
  EXPECT_EQ((*film)->skipped()[0].find(path + ": frame "), 0U) << (*film)->skipped()[0];
}

std::vector<Frame> noisy_frames(std::int64_t count, std::uint64_t seed) {
  detail::Random random(seed);
  std::vector<Frame> frames;
  for (std::int64_t i = 0; i < count; ++i) frames.push_back(noisy_frame(160, 120, i, random));
  return frames;
}

/// A film as another program would write it: without the capture times and checksums of a recorded one.
std::string foreign_film(const std::string& path, FilmCoding coding, const std::vector<Frame>& frames) {
  {
    auto recorder = Recorder::open(path, {}, coding);
    EXPECT_TRUE(recorder) << recorder.error();
    for (const Frame& frame : frames) (*recorder)->add(frame);
  }
  std::string bytes = test::read_file(path);
  const std::string note = "SKEIN_FILM";
  bytes.replace(bytes.find(note), note.size(), "OTHER_FILM");
  test::write_file(path, bytes);
  return bytes;
}

/// What is handed on of a film is what it would be without its damage. Returns the number of frames that are not.
std::size_t expect_only_whole_frames(const std::string& path, const std::string& bytes) {
  const auto read_all = [&](std::vector<std::string>& said) {
    auto film = open_source("video:" + path);
    EXPECT_TRUE(film) << film.error();
    EXPECT_FALSE((*film)->recorded());
    std::vector<Frame> all;
    for (Frame frame; (*film)->read(frame).value();) all.push_back(frame);
    said.assign((*film)->skipped().begin(), (*film)->skipped().end());
    return std::pair{all, (*film)->status().damaged};
  };
  std::vector<std::string> said;
  const auto [whole, none] = read_all(said);
  EXPECT_EQ(said, std::vector<std::string>()) << "the control";
  EXPECT_EQ(none, 0);
  test::write_file(path, bytes);
  const auto [left, damaged] = read_all(said);
  EXPECT_EQ(damaged, static_cast<std::int64_t>(whole.size() - left.size()));
  EXPECT_FALSE(said.empty());
  for (const Frame& frame : left)
    EXPECT_EQ(frame.grey, whole[static_cast<std::size_t>(frame.index)].grey) << frame.index;
  return whole.size() - left.size();
}

/// ffmpeg keeps the notes of a film that it codes anew as Matroska, not what is beside the frames: such a film was
/// taken for a recorded one, and not a single frame of it could be read.
TEST(Recorder, AFilmThatAnotherProgramCodesAnewIsItsOwn) {
  test::Folder folder;
  const std::string path = folder.file("film.mkv");
  const std::vector<Frame> frames = noisy_frames(3, 19);
  {
    auto recorder = Recorder::open(path, {{"CALIBRATION", "of the camera"}});
    ASSERT_TRUE(recorder) << recorder.error();
    for (const Frame& frame : frames) (*recorder)->add(frame);
  }
  ASSERT_TRUE(open_source("video:" + path).value()->recorded()) << "the control";
  std::string bytes = test::read_file(path);
  const std::string beside = "\x75\xa1";  // Matroska's BlockAdditions
  for (std::size_t at = bytes.find(beside); at != std::string::npos; at = bytes.find(beside, at))
    bytes[at + 1] = '\xac';
  test::write_file(path, bytes);
  const auto film = open_source("video:" + path);
  ASSERT_TRUE(film) << film.error();
  EXPECT_FALSE((*film)->recorded());
  EXPECT_EQ((*film)->notes().at("CALIBRATION"), "of the camera");
  Frame frame;
  for (const Frame& written : frames) {
    ASSERT_TRUE((*film)->read(frame).value());
    EXPECT_EQ(frame.grey, written.grey);
  }
  EXPECT_FALSE((*film)->read(frame).value());
}

TEST(Recorder, ADamagedFrameOfAForeignFilmIsLeftOut) {
  test::Folder folder;
  std::string bytes = foreign_film(folder.file("film.mkv"), FilmCoding::lossless, noisy_frames(10, 17));
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
  EXPECT_EQ(expect_only_whole_frames(folder.file("film.mkv"), bytes), 1U);
}

/// FFmpeg shows them, made of what was before the damage.
TEST(Recorder, FramesThatBuildOnADamagedOneAreLeftOut) {
  test::Folder folder;
  std::string bytes = foreign_film(folder.file("film.mkv"), FilmCoding::small, noisy_frames(60, 18));
  const std::size_t at = bytes.size() / 2;
  for (std::size_t k = at; k < at + 40; ++k) bytes[k] = static_cast<char>(bytes[k] ^ 0x5a);
  const std::size_t left_out = expect_only_whole_frames(folder.file("film.mkv"), bytes);
  EXPECT_GT(left_out, 1U);
  EXPECT_LE(left_out, 25U) << "up to the next picture that builds on no other";
}

TEST(Recorder, ASlowDiskCostsFramesAndTheyAreCounted) {
  Bench bench;
  bench.held = true;
  Recorder recorder(std::make_unique<BenchFilm>(bench), 3);
  detail::Random random(8);
  const auto frame = [&](std::int64_t i) { return noisy_frame(16, 16, i, random); };
  EXPECT_TRUE(recorder.offer(frame(0)));
  bench.wait_for_writing(1);  // it has left the queue only when it is written
  EXPECT_TRUE(recorder.offer(frame(1)));
  EXPECT_TRUE(recorder.offer(frame(2)));
  EXPECT_FALSE(recorder.offer(frame(3))) << "and does not wait";
  EXPECT_FALSE(recorder.offer(frame(4)));
  EXPECT_EQ(recorder.status().dropped, 2);
  bench.hold(false);
  bench.wait_for_writing(3);
  recorder.add(frame(5));
  const RecorderStatus status = recorder.finish();
  EXPECT_EQ(status.written, 4);
  EXPECT_EQ(status.dropped, 2);
  EXPECT_EQ(bench.written, (std::vector<std::int64_t>{0, 1, 2, 5}));
}

TEST(Recorder, ABrokenWriterIsReportedAndHoldsNobodyUp) {
  Bench bench;
  bench.problem = "no room left";
  Recorder recorder(std::make_unique<BenchFilm>(bench), 2);
  for (std::int64_t i = 0; i < 100; ++i) recorder.add(test::uniform_frame(8, 8, 0));
  EXPECT_FALSE(recorder.offer(test::uniform_frame(8, 8, 0)));
  const RecorderStatus status = recorder.finish();
  EXPECT_EQ(status.problem, "no room left");
  EXPECT_EQ(status.written, 0);
  EXPECT_EQ(status.dropped, 101);
  EXPECT_EQ(bench.writing, 1) << "it is not tried again";
}

TEST(Recorder, AFullDiskIsReported) {
  detail::Random random(9);
  auto recorder = Recorder::open("/dev/full");
  ASSERT_TRUE(recorder) << recorder.error();
  for (std::int64_t i = 0; i < 30; ++i) (*recorder)->add(noisy_frame(320, 240, i, random));
  const RecorderStatus status = (*recorder)->finish();
  EXPECT_EQ(status.problem, "/dev/full: cannot be written: No space left on device");
  EXPECT_EQ(status.written + status.dropped, 30);
}

TEST(Recorder, AFrameOfAnotherSizeEndsTheFilm) {
  test::Folder folder;
  auto recorder = Recorder::open(folder.file("film.mkv"));
  ASSERT_TRUE(recorder) << recorder.error();
  (*recorder)->add(test::uniform_frame(32, 16, 0));
  (*recorder)->add(test::uniform_frame(16, 16, 0));
  const RecorderStatus status = (*recorder)->finish();
  EXPECT_EQ(status.problem, folder.file("film.mkv") + ": frame 0 is 16x16 px, and the film 32x16");
  EXPECT_EQ(status.written, 1);
  EXPECT_EQ(status.dropped, 1);
}

/// A kept run has its film as another name of the same bytes.
TEST(Recorder, ANewFilmLeavesOtherNamesOfAnOldOneAlone) {
  test::Folder folder;
  const std::string path = folder.file("film.mkv"), kept = folder.file("kept.mkv");
  const auto film_of = [&](int frames) {
    auto recorder = Recorder::open(path);
    ASSERT_TRUE(recorder) << recorder.error();
    for (int i = 0; i < frames; ++i) (*recorder)->add(test::uniform_frame(32, 16, static_cast<std::uint8_t>(i)));
  };
  film_of(3);
  std::filesystem::create_hard_link(path, kept);
  const std::string before = test::read_file(kept);
  film_of(1);
  EXPECT_EQ(test::read_file(kept), before);
  EXPECT_NE(test::read_file(path), before);
  std::filesystem::remove(path);
  std::filesystem::create_symlink(kept, path);
  film_of(1);
  EXPECT_TRUE(std::filesystem::is_symlink(path)) << "a link to a film stays one";
  EXPECT_NE(test::read_file(kept), before);
}

/// A private one stays private.
TEST(Recorder, ANewFilmHasTheRightsOfTheOldOne) {
  constexpr auto own = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;
  test::Folder folder;
  const std::string path = folder.file("film.mkv");
  std::ofstream(path) << "an old one";
  std::filesystem::permissions(path, own);
  {
    auto recorder = Recorder::open(path);
    ASSERT_TRUE(recorder) << recorder.error();
    (*recorder)->add(test::uniform_frame(32, 16, 0));
  }
  EXPECT_EQ(std::filesystem::status(path).permissions(), own);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(std::filesystem::path(path).parent_path()), {}), 1)
      << "nothing is left beside it";
}

TEST(Recorder, SaysWhereItCannotWrite) {
  const auto recorder = Recorder::open("/no/such/folder/film.mkv");
  ASSERT_FALSE(recorder);
  EXPECT_EQ(recorder.error(), "/no/such/folder/film.mkv: cannot be written: No such file or directory");
}

}  // namespace
}  // namespace skein::vision
