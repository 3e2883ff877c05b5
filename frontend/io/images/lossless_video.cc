#include "frontend/io/images/lossless_video.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "frontend/io/images/frame_mark.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
}

namespace tagtwist::internal {
namespace {

constexpr AVRational kMilliseconds{1, 1000};  // Matroska's
constexpr int kBuffer = 1 << 16;

// Of libavformat's: `size` bytes to a descriptor, or an error of FFmpeg's.
int WriteToDescriptor(void* descriptor, uint8_t* bytes, int size) {
  for (int done = 0; done < size;) {
    const ssize_t written =
        ::write(*static_cast<int*>(descriptor), bytes + done, static_cast<size_t>(size - done));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return AVERROR(errno);
    done += static_cast<int>(written);
  }
  return size;
}

int64_t SeekInDescriptor(void* descriptor, int64_t offset, int whence) {
  if ((whence & AVSEEK_SIZE) != 0) return AVERROR(ENOSYS);
  const off_t at = ::lseek(*static_cast<int*>(descriptor), offset, whence & ~AVSEEK_FORCE);
  return at < 0 ? AVERROR(errno) : at;
}

// The encoder reads rows that are a multiple of its vectors' size apart.
int CopyInto(const cv::Mat& gray, AVFrame* frame) {
  if (const int failure = av_frame_make_writable(frame); failure < 0) return failure;
  av_image_copy_plane(frame->data[0], frame->linesize[0], gray.data, static_cast<int>(gray.step),
                      gray.cols, gray.rows);
  return 0;
}

int MarkPacket(int64_t t_ns, AVPacket* packet) {
  constexpr size_t kIdBytes = 8;  // a number, big-endian: 1
  const std::string mark = FrameMark(t_ns);
  uint8_t* data =
      av_packet_new_side_data(packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, kIdBytes + mark.size());
  if (data == nullptr) return AVERROR(ENOMEM);
  std::memset(data, 0, kIdBytes);
  data[kIdBytes - 1] = 1;
  std::memcpy(data + kIdBytes, mark.data(), mark.size());
  return 0;
}

}  // namespace

// All that libavformat and libavcodec hold, from the first image on; errors are FFmpeg's, below 0.
struct LosslessVideo::Stream {
  explicit Stream(int file) : descriptor(file) {}
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() {
    av_packet_free(&packet);
    av_frame_free(&frame);
    avcodec_free_context(&encoder);
    avformat_free_context(output);
    if (bytes != nullptr) av_freep(&bytes->buffer);
    avio_context_free(&bytes);
    ::close(descriptor);
  }

  int OpenEncoder(const cv::Size& size) {
    const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_FFV1);
    if (codec == nullptr) return AVERROR_ENCODER_NOT_FOUND;
    encoder = avcodec_alloc_context3(codec);
    frame = av_frame_alloc();
    packet = av_packet_alloc();
    if (encoder == nullptr || frame == nullptr || packet == nullptr) return AVERROR(ENOMEM);
    encoder->width = frame->width = size.width;
    encoder->height = frame->height = size.height;
    encoder->pix_fmt = AV_PIX_FMT_GRAY8;
    frame->format = AV_PIX_FMT_GRAY8;
    encoder->time_base = kMilliseconds;
    encoder->gop_size = 1;      // each frame whole by itself
    encoder->level = 3;         // with checksums
    encoder->thread_count = 1;  // no frame waits for others
    encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    if (const int failure = avcodec_open2(encoder, codec, nullptr); failure < 0) return failure;
    return av_frame_get_buffer(frame, 0);
  }

  int OpenOutput() {
    auto* buffer = static_cast<uint8_t*>(av_malloc(kBuffer));
    if (buffer == nullptr) return AVERROR(ENOMEM);
    bytes = avio_alloc_context(buffer, kBuffer, 1, &descriptor, nullptr, WriteToDescriptor,
                               SeekInDescriptor);
    if (bytes == nullptr) {
      av_free(buffer);
      return AVERROR(ENOMEM);
    }
    const int made = avformat_alloc_output_context2(&output, nullptr, "matroska", nullptr);
    if (made < 0) return made;
    output->pb = bytes;
    output->flags |= AVFMT_FLAG_CUSTOM_IO | AVFMT_FLAG_BITEXACT;
    AVStream* stream = avformat_new_stream(output, nullptr);
    if (stream == nullptr) return AVERROR(ENOMEM);
    stream->time_base = kMilliseconds;
    const int taken = avcodec_parameters_from_context(stream->codecpar, encoder);
    return taken < 0 ? taken : avformat_write_header(output, nullptr);
  }

  int Write(int64_t since_first_ns, int64_t t_ns, const cv::Mat& gray) {
    if (const int failure = CopyInto(gray, frame); failure < 0) return failure;
    frame->pts = since_first_ns / 1'000'000;
    if (const int failure = avcodec_send_frame(encoder, frame); failure < 0) return failure;
    if (const int failure = avcodec_receive_packet(encoder, packet); failure < 0) return failure;
    packet->stream_index = 0;
    av_packet_rescale_ts(packet, kMilliseconds, output->streams[0]->time_base);
    int failure = MarkPacket(t_ns, packet);
    if (failure >= 0) failure = av_write_frame(output, packet);
    av_packet_unref(packet);
    if (failure >= 0) failure = av_write_frame(output, nullptr);  // ends the cluster
    avio_flush(bytes);
    return failure < 0 ? failure : bytes->error;
  }

  int descriptor;
  AVIOContext* bytes = nullptr;
  AVFormatContext* output = nullptr;
  AVCodecContext* encoder = nullptr;
  AVFrame* frame = nullptr;
  AVPacket* packet = nullptr;
};

LosslessVideo::LosslessVideo(std::string path, std::unique_ptr<Stream> stream)
    : path_(std::move(path)), stream_(std::move(stream)) {}

LosslessVideo::~LosslessVideo() {
  if (stream_->output == nullptr) ::unlink(path_.c_str());  // empty
}

Result<std::unique_ptr<LosslessVideo>> LosslessVideo::Create(const std::string& path) {
  av_log_set_level(AV_LOG_QUIET);
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0 && errno == EEXIST) return Error{path + ": exists already"};
  if (descriptor < 0) {
    return Error{path + ": cannot write: " + std::generic_category().message(errno)};
  }
  return std::unique_ptr<LosslessVideo>(
      new LosslessVideo(path, std::make_unique<Stream>(descriptor)));
}

Status LosslessVideo::Fail(const std::string& why) {
  failed_ = true;
  return Error{path_ + ": cannot write: " + why};
}

Status LosslessVideo::FailAs(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return Fail(text);
}

Status LosslessVideo::Add(int64_t t_ns, const cv::Mat& gray) {
  if (failed_) return Ok();
  Stream& stream = *stream_;
  if (gray.type() != CV_8UC1 || gray.empty()) return Fail("expected 8-bit gray images");
  if (stream.output == nullptr) {
    first_ns_ = t_ns;
    int failure = stream.OpenEncoder(gray.size());
    if (failure >= 0) failure = stream.OpenOutput();
    if (failure < 0) return FailAs(failure);
  }
  if (gray.cols != stream.encoder->width || gray.rows != stream.encoder->height) {
    return Fail("images of different sizes");
  }
  const int failure = stream.Write(t_ns - first_ns_, t_ns, gray);
  return failure < 0 ? FailAs(failure) : Ok();
}

Status LosslessVideo::Finish() {
  if (failed_) return Ok();
  failed_ = true;  // nothing comes after the end
  if (stream_->output == nullptr) return Ok();
  int failure = av_write_trailer(stream_->output);
  avio_flush(stream_->bytes);
  if (failure >= 0) failure = stream_->bytes->error;
  return failure < 0 ? FailAs(failure) : Ok();
}

}  // namespace tagtwist::internal
