#include "frontend/io/images/video_times.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "frontend/io/images/frame_mark.h"
#include "frontend/io/images/image_file.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libavutil/display.h>
#include <libavutil/log.h>
#include <libavutil/mem.h>
}

namespace tagtwist::internal {
namespace {

struct CloseInput {
  void operator()(AVFormatContext* context) const { avformat_close_input(&context); }
};
struct FreeDecoder {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
using Input = std::unique_ptr<AVFormatContext, CloseInput>;
using Decoder = std::unique_ptr<AVCodecContext, FreeDecoder>;

double ToHz(const AVRational& rate) { return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0; }

// A kilobyte may declare a table of a gigabyte: no more is asked for at once than a frame within
// the limits takes, of eight bytes a pixel.
Input OpenInput(const std::string& path, const Limits& limits) {
  constexpr size_t kBytesAPixel = 8;
  av_log_set_level(AV_LOG_QUIET);
  av_max_alloc(kBytesAPixel * static_cast<size_t>(limits.frame_pixels));
  AVFormatContext* context = nullptr;
  if (avformat_open_input(&context, ("file:" + path).c_str(), nullptr, nullptr) < 0) return {};
  return Input(context);
}

std::optional<std::string> SizeFault(const AVFormatContext& input, const Limits& limits) {
  for (unsigned i = 0; i < input.nb_streams; ++i) {
    const AVCodecParameters& stream = *input.streams[i]->codecpar;
    if (stream.codec_type != AVMEDIA_TYPE_VIDEO || stream.width <= 0 || stream.height <= 0) {
      continue;
    }
    const auto fault = FrameSizeFault(static_cast<uint64_t>(stream.width),
                                      static_cast<uint64_t>(stream.height), limits);
    if (fault) return fault;
  }
  return std::nullopt;
}

// Decodes the first frames, to know what the streams are; of none that is larger than the bound.
bool FindStreams(AVFormatContext* input, const Limits& limits) {
  const unsigned count = input->nb_streams;
  std::vector<AVDictionary*> options(count + 1, nullptr);
  for (AVDictionary*& of_stream : options) {
    av_dict_set_int(&of_stream, "max_pixels", limits.frame_pixels, 0);
  }
  const bool found = avformat_find_stream_info(input, options.data()) >= 0;
  for (AVDictionary*& of_stream : options) av_dict_free(&of_stream);
  return found;
}

Decoder OpenDecoder(const AVStream& stream, const Limits& limits) {
  const AVCodec* codec = avcodec_find_decoder(stream.codecpar->codec_id);
  if (codec == nullptr) return {};
  Decoder decoder(avcodec_alloc_context3(codec));
  if (!decoder || avcodec_parameters_to_context(decoder.get(), stream.codecpar) < 0) return {};
  decoder->pkt_timebase = stream.time_base;
  decoder->max_pixels = limits.frame_pixels;
  decoder->thread_count = 0;  // as many as there are cores
  if (avcodec_open2(decoder.get(), codec, nullptr) < 0) return {};
  return decoder;
}

// The display matrix tells a turn against the clock.
int TurnOf(const AVStream& stream) {
  const uint8_t* matrix = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
  if (matrix == nullptr) return 0;
  const double turn_deg = av_display_rotation_get(reinterpret_cast<const int32_t*>(matrix));
  if (!std::isfinite(turn_deg)) return 0;
  const auto quarters = std::lround(-turn_deg / 90);
  return static_cast<int>(((quarters % 4) + 4) % 4) * 90;
}

// Stamps in ns that packets carry beside the container's times.
class MarkedStamps {
 public:
  void Take(const AVPacket& packet) {
    constexpr size_t kIdBytes = 8;
    size_t size = 0;
    const uint8_t* data =
        av_packet_get_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, &size);
    if (data == nullptr || size <= kIdBytes) return;
    const auto* text = reinterpret_cast<const char*>(data + kIdBytes);
    const auto t_ns = ReadFrameMark(std::string_view(text, strnlen(text, size - kIdBytes)));
    if (t_ns) waiting_.emplace(packet.pts, *t_ns);
  }
  void Decoded(const AVFrame& frame) {
    const auto mark = waiting_.find(frame.pts);
    if (mark == waiting_.end()) return;
    stamps_ns_.emplace_back(mark->second);
    waiting_.erase(mark);
  }
  const std::vector<std::optional<int64_t>>& stamps_ns() const { return stamps_ns_; }

 private:
  std::multimap<int64_t, int64_t> waiting_;  // by the container's time, in order of arrival
  std::vector<std::optional<int64_t>> stamps_ns_;
};

// Whether all frames have the size that the stream begins with. A camera's have; and where it
// changes OpenCV reads past the smaller ones, also where a frame that cannot be decoded has
// announced another.
class FrameSizes {
 public:
  explicit FrameSizes(const AVStream& stream)
      : width_(stream.codecpar->width), height_(stream.codecpar->height) {}
  void Take(const AVFrame& frame) { Compare(frame.width, frame.height, count_++); }
  void Announced(const AVCodecContext& decoder) { Compare(decoder.width, decoder.height, count_); }
  const std::string& fault() const { return fault_; }

 private:
  void Compare(int width, int height, int frame) {
    if (width_ == 0) width_ = width, height_ = height;  // nothing is announced
    if (!fault_.empty() || (width == width_ && height == height_)) return;
    fault_ = "frame " + std::to_string(frame) + ": expected " + Text(width_, height_) +
             " px as the stream begins, got " + Text(width, height);
  }
  static std::string Text(int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
  }
  int count_ = 0, width_, height_;
  std::string fault_;
};

// Takes what the decoder has ready.
void TakeFrames(AVCodecContext* decoder, const AVStream& stream, AVFrame* frame,
                MarkedStamps* marked, FrameSizes* sizes, VideoTimes* out) {
  const int64_t start = stream.start_time == AV_NOPTS_VALUE ? 0 : stream.start_time;
  while (avcodec_receive_frame(decoder, frame) >= 0) {
    sizes->Take(*frame);
    const int64_t time = frame->best_effort_timestamp;
    if (time == AV_NOPTS_VALUE) {
      out->stamps_ns.emplace_back();
    } else {
      out->stamps_ns.emplace_back(
          av_rescale_q(time - start, stream.time_base, AVRational{1, 1'000'000'000}));
    }
    marked->Decoded(*frame);
    av_frame_unref(frame);
  }
}

int64_t MedianInterval(const std::vector<std::optional<int64_t>>& stamps_ns) {
  std::vector<int64_t> intervals;
  for (size_t i = 1; i < stamps_ns.size(); ++i) {
    if (stamps_ns[i] && stamps_ns[i - 1] && *stamps_ns[i] > *stamps_ns[i - 1]) {
      intervals.push_back(*stamps_ns[i] - *stamps_ns[i - 1]);
    }
  }
  if (intervals.empty()) return 0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

RepairedStamps StampsByRate(size_t frames, double rate_hz) {
  RepairedStamps out;
  out.by_rate = true;
  out.kept.assign(frames, true);
  for (size_t i = 0; i < frames; ++i) {
    out.stamps_ns.push_back(std::llround(1e9 * static_cast<double>(i) / rate_hz));
  }
  return out;
}

}  // namespace

Result<VideoTimes> ReadVideoTimes(const std::string& path, const Limits& limits) {
  const Error no_video{
      path + ": expected a course .mat, a video or a folder, got neither, or a damaged file"};
  const Input input = OpenInput(path, limits);
  if (!input) return no_video;
  // Before a frame is decoded, and again with what the first frames say.
  if (const auto fault = SizeFault(*input, limits)) return Error{path + ": " + *fault};
  if (!FindStreams(input.get(), limits)) return no_video;
  if (const auto fault = SizeFault(*input, limits)) return Error{path + ": " + *fault};
  const int index = av_find_best_stream(input.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) return no_video;
  const AVStream& stream = *input->streams[index];
  const Decoder decoder = OpenDecoder(stream, limits);
  if (!decoder) return no_video;
  VideoTimes out;
  out.step_s = ToHz(stream.time_base);
  out.rate_hz = ToHz(stream.avg_frame_rate);
  if (out.rate_hz == 0) out.rate_hz = ToHz(stream.r_frame_rate);
  if (input->duration > 0) out.duration_s = static_cast<double>(input->duration) / AV_TIME_BASE;
  out.announced_frames = stream.nb_frames;
  out.turn_clockwise_deg = TurnOf(stream);
  const std::unique_ptr<AVFrame, FreeFrame> frame(av_frame_alloc());
  const std::unique_ptr<AVPacket, FreePacket> packet(av_packet_alloc());
  MarkedStamps marked;
  FrameSizes sizes(stream);
  while (av_read_frame(input.get(), packet.get()) >= 0) {
    if (packet->stream_index == index) {
      marked.Take(*packet);
      avcodec_send_packet(decoder.get(), packet.get());
      sizes.Announced(*decoder);
      TakeFrames(decoder.get(), stream, frame.get(), &marked, &sizes, &out);
    }
    av_packet_unref(packet.get());
  }
  avcodec_send_packet(decoder.get(), nullptr);
  TakeFrames(decoder.get(), stream, frame.get(), &marked, &sizes, &out);
  if (!sizes.fault().empty()) return Error{path + ": " + sizes.fault()};
  if (marked.stamps_ns().size() == out.stamps_ns.size()) {  // all frames have one
    out.stamps_ns = marked.stamps_ns();
    out.step_s = 0;
  }
  return out;
}

double RoundingOf(const std::vector<int64_t>& stamps_ns, double step_s) {
  std::vector<int64_t> intervals_ns;
  for (size_t i = 1; i < stamps_ns.size(); ++i) {
    intervals_ns.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  }
  if (intervals_ns.empty()) return 0;
  const int64_t shortest_ns = *std::min_element(intervals_ns.begin(), intervals_ns.end());
  if (shortest_ns <= 0) return step_s;
  const bool exact = std::all_of(intervals_ns.begin(), intervals_ns.end(), [&](int64_t ns) {
    const int64_t over_ns = ns % shortest_ns, n = ns / shortest_ns;
    return std::min(over_ns, shortest_ns - over_ns) <= n + 1;  // nanoseconds are rounded, too
  });
  return exact ? 0 : step_s;
}

Result<RepairedStamps> RepairStamps(const VideoTimes& times) {
  const auto& given = times.stamps_ns;
  const bool any = std::any_of(given.begin(), given.end(), [](const auto& t) { return t; });
  if (!any) {
    if (!(times.rate_hz > 0)) return Error{"a video with neither times nor a frame rate"};
    return StampsByRate(given.size(), times.rate_hz);
  }
  int64_t interval_ns = MedianInterval(given);
  if (interval_ns == 0) {
    if (!(times.rate_hz > 0)) return Error{"a video with neither times nor a frame rate"};
    interval_ns = std::llround(1e9 / times.rate_hz);
  }
  RepairedStamps out;
  for (const std::optional<int64_t>& stamp_ns : given) {
    const bool first = out.stamps_ns.empty();
    const int64_t t_ns = stamp_ns ? *stamp_ns : first ? 0 : out.stamps_ns.back() + interval_ns;
    const bool grows = first || t_ns > out.stamps_ns.back();
    out.kept.push_back(grows);
    out.invented += grows && !stamp_ns ? 1 : 0;
    out.dropped += grows ? 0 : 1;
    if (grows) out.stamps_ns.push_back(t_ns);
  }
  return out;
}

}  // namespace tagtwist::internal
