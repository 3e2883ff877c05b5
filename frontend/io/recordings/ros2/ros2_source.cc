// ROS 2 bags, without ROS.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <utility>

#include "frontend/base/printable.h"
#include "frontend/io/recordings/bag_topics.h"
#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/recordings/ros2/ros2_bag.h"
#include "frontend/io/recordings/ros2/ros2_messages.h"
#include "frontend/io/recordings/ros2/ros2_topics.h"
#include "frontend/io/tables/growing_stamps.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

Result<std::unique_ptr<Ros2Bag>> OpenFile(const std::string& path, const Limits& limits) {
  return IsRos2Mcap(path) ? OpenRos2Mcap(path, limits) : OpenRos2Sqlite(path);
}

// The files of a bag, in order of their names' lengths and names: r_2 before r_10.
Result<Names> FilesOf(const std::string& path) {
  std::error_code unknown;
  if (!fs::is_directory(path, unknown)) return Names{path};
  Names out;
  for (const auto& entry : fs::directory_iterator(path, unknown)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".db3" || ending == ".mcap") out.push_back(entry.path().string());
    if (ending == ".zstd") {
      return Error{entry.path().string() + ": a compressed file of a ROS 2 bag: unzstd it first"};
    }
  }
  std::sort(out.begin(), out.end(), [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  if (out.empty()) return Error{path + ": a ROS 2 bag without a .db3 or .mcap file"};
  return out;
}

Result<Ros2Bags> OpenFiles(const std::string& path, const Limits& limits) {
  const auto files = FilesOf(path);
  if (!files) return files.error();
  Ros2Bags out;
  for (const std::string& file : *files) {
    auto bag = OpenFile(file, limits);
    if (!bag) return bag.error();
    out.push_back(std::move(*bag));
  }
  return out;
}

// The headers' stamps, or, where none was ever set, the arrivals'.
std::vector<int64_t> ChooseStamps(const std::vector<int64_t>& headers_ns,
                                  const std::vector<int64_t>& arrivals_ns) {
  const bool set = std::any_of(headers_ns.begin(), headers_ns.end(), [](int64_t t) { return t; });
  return set ? headers_ns : arrivals_ns;
}

class Ros2Source : public DataSource {
 public:
  Ros2Source(std::string path, const DataSourceOptions& options)
      : path_(std::move(path)), options_(options) {}

  Status Open() {
    auto bags = OpenFiles(path_, options_.limits);
    if (!bags) return bags.error();
    bags_ = std::move(*bags);
    const auto fits = options_.use_detections ? IsRos2Tags : IsRos2Image;
    const Names topics = Ros2TopicsThat(bags_, fits);
    if (options_.use_detections && topics.empty()) {
      return Error{path_ +
                   ": no topic of the bag has detections to use: leave out --use_detections"};
    }
    const auto topic = ChooseImageTopic(topics, options_.topic);
    if (!topic) return Error{path_ + ": " + topic.error().message};
    topic_ = *topic;
    if (const Status read = ReadStamps(); !read) return read;
    if (const Status read = ReadTruth(); !read) return read;
    if (const Status read = ReadImu(); !read) return read;
    reader_.emplace(bags_, topic_);
    return Ok();
  }

  Result<std::optional<Frame>> Next() override {
    if (next_ == stamps_ns_.size()) return std::optional<Frame>();
    std::optional<Ros2Typed> typed;
    while (position_ <= kept_[next_]) {  // those between are passed over
      auto message = reader_->Next();
      if (!message) return message.error();
      if (!*message) return Error{path_ + ": has changed while it was read"};
      typed = std::move(**message);
      ++position_;
    }
    Frame frame;
    frame.t_ns = stamps_ns_[next_];
    frame.name = NameOf(kept_[next_++]);
    if (options_.use_detections) {
      auto tags = ReadRos2Tags(typed->type, typed->message.data);
      if (tags) frame.detections = std::move(*tags);
      return std::optional<Frame>(std::move(frame));
    }
    if (!options_.read_images) return std::optional<Frame>(std::move(frame));
    auto image = ReadRos2Image(typed->type, typed->message.data, options_.limits);
    if (image) {
      if (auto fault = size_guard_.Check(*image, frame.name)) return *fault;
      frame.image = std::move(*image);
    } else if (image.error().message.rfind("encoding", 0) == 0) {
      return Error{frame.name + ": " + image.error().message};
    } else {
      frame.image_problem = image.error().message;
    }
    return std::optional<Frame>(std::move(frame));
  }

  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }
  const std::vector<TruthSample>& ground_truth() const override { return truth_; }
  const std::vector<ImuSample>& imu() const override { return imu_; }
  const std::vector<std::string>& notes() const override { return notes_; }
  std::string truth_origin() const override { return truth_origin_; }

 private:
  std::string NameOf(size_t index) const {
    return path_ + ": " + Printable(topic_) + ", message " + std::to_string(index);
  }

  // Messages that do not decode are passed over, and counted.
  Status ReadStamps() {
    Ros2TopicReader reader(bags_, topic_);
    std::vector<int64_t> headers_ns, arrivals_ns;
    std::vector<size_t> readable;
    size_t count = 0;
    for (;; ++count) {
      auto message = reader.Next();
      if (!message) return message.error();
      if (!*message) break;
      const auto t_ns = HeaderStamp((*message)->message.data);
      if (!t_ns) continue;
      readable.push_back(count);
      headers_ns.push_back(*t_ns);
      arrivals_ns.push_back((*message)->message.arrival_ns);
    }
    if (readable.size() < count) {
      notes_.push_back(path_ + ": passed over " + std::to_string(count - readable.size()) + " of " +
                       std::to_string(count) + " messages on " + Printable(topic_) +
                       " that do not decode");
    }
    const std::vector<int64_t> stamps_ns = ChooseStamps(headers_ns, arrivals_ns);
    const auto growing = KeepGrowing(stamps_ns);
    if (!growing) return Error{path_ + ": " + Printable(topic_) + ": " + growing.error().message};
    for (const size_t i : growing->kept) {
      kept_.push_back(readable[i]);
      stamps_ns_.push_back(stamps_ns[i]);
    }
    if (!growing->All()) {
      notes_.push_back(path_ + ": " +
                       PassedOverText(*growing, "messages on " + topic_,
                                      "message " + std::to_string(growing->first_passed_over)));
    }
    return Ok();
  }

  template <typename Sample>
  Status ReadSamples(const std::string& topic,
                     const std::function<Result<Sample>(const Ros2Typed&)>& read,
                     std::vector<Sample>* out) {
    Ros2TopicReader reader(bags_, topic);
    std::vector<Sample> all;
    std::vector<int64_t> headers_ns, arrivals_ns;
    size_t bad = 0;
    for (;;) {
      auto message = reader.Next();
      if (!message) return message.error();
      if (!*message) break;
      const auto sample = read(**message);
      bad += sample ? 0 : 1;
      if (!sample) continue;
      all.push_back(*sample);
      headers_ns.push_back(sample->t_ns);
      arrivals_ns.push_back((*message)->message.arrival_ns);
    }
    const auto stamps_ns = ChooseStamps(headers_ns, arrivals_ns);
    size_t disordered = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      all[i].t_ns = stamps_ns[i];
      const bool grows = out->empty() || all[i].t_ns > out->back().t_ns;
      disordered += grows ? 0 : 1;
      if (grows) out->push_back(all[i]);
    }
    if (bad + disordered > 0) {
      notes_.push_back(path_ + ": passed over " + std::to_string(bad + disordered) + " of " +
                       std::to_string(all.size() + bad) + " messages on " + Printable(topic) +
                       ": without a pose or numbers, or out of order");
    }
    return Ok();
  }

  Status ReadTruth() {
    const auto truth = ChooseTruth(Ros2TopicsThat(bags_, IsRos2Pose),
                                   Ros2TopicsThat(bags_, IsRos2Transforms), options_.truth_topic);
    if (!truth) return Error{path_ + ": " + truth.error().message};
    if (!truth->note.empty()) notes_.push_back(path_ + ": " + truth->note);
    truth_origin_ = truth->Origin();
    if (truth->name.empty()) return Ok();
    if (!truth->child.empty()) return ReadTransforms(*truth);
    return ReadSamples<TruthSample>(
        truth->name,
        [](const Ros2Typed& typed) { return ReadRos2Pose(typed.type, typed.message.data); },
        &truth_);
  }

  Status ReadTransforms(const TruthTopic& topic) {
    TransformsOfFrame transforms(topic);
    for (Ros2TopicReader reader(bags_, topic.name);;) {
      const auto message = reader.Next();
      if (!message) return message.error();
      if (!*message) break;
      if (const auto all = ReadRos2Transforms((*message)->message.data)) transforms.Add(*all);
    }
    auto taken = transforms.Take();
    if (!taken) return Error{path_ + ": " + taken.error().message};
    truth_ = std::move(*taken);
    return Ok();
  }

  Status ReadImu() {
    const Names topics = Ros2TopicsThat(bags_, IsRos2Imu);
    if (topics.size() != 1) return Ok();
    return ReadSamples<ImuSample>(
        topics.front(), [](const Ros2Typed& typed) { return ReadRos2Imu(typed.message.data); },
        &imu_);
  }

  std::string path_;
  DataSourceOptions options_;
  Ros2Bags bags_;
  std::string topic_, truth_origin_;
  std::vector<size_t> kept_;  // the frames' messages on the topic
  std::vector<int64_t> stamps_ns_;
  std::vector<TruthSample> truth_;
  std::vector<ImuSample> imu_;
  std::vector<std::string> notes_;
  std::optional<Ros2TopicReader> reader_;
  size_t position_ = 0, next_ = 0;  // messages read, frames handed out
  ImageSizeGuard size_guard_;
};

}  // namespace

bool IsRos2Bag(const std::string& path) {
  std::error_code unknown;
  if (!fs::is_directory(path, unknown)) return IsRos2Sqlite(path) || IsRos2Mcap(path);
  if (!fs::exists(fs::path(path) / "metadata.yaml", unknown)) return false;
  for (const auto& entry : fs::directory_iterator(path, unknown)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".db3" || ending == ".mcap" || ending == ".zstd") return true;
  }
  return false;
}

Result<RosCameraInfo> ReadRos2CameraInfo(const std::string& path, const std::string& topic,
                                         const Limits& limits) {
  const auto bags = OpenFiles(path, limits);
  if (!bags) return bags.error();
  const auto chosen = ChooseCameraTopic(Ros2TopicsThat(*bags, IsRos2CameraInfo), topic);
  if (!chosen) return Error{path + ": " + chosen.error().message};
  for (Ros2TopicReader reader(*bags, *chosen);;) {
    const auto message = reader.Next();
    if (!message) return message.error();
    if (!*message) return Error{path + ": no message on " + *chosen + " decodes"};
    auto info = ReadRos2CameraInfoMessage((*message)->message.data);
    if (info) return info;
  }
}

Result<std::unique_ptr<DataSource>> OpenRos2Source(const std::string& path,
                                                   const DataSourceOptions& options) {
  auto source = std::make_unique<Ros2Source>(path, options);
  if (const Status opened = source->Open(); !opened) return opened.error();
  return std::unique_ptr<DataSource>(std::move(source));
}

}  // namespace tagtwist::internal
