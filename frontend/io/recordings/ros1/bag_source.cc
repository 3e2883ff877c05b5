// ROS 1 bags, through ROS' own library. Where it is not installed bag_source_missing.cc stands for
// this file.
#include <console_bridge/console.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <utility>

#include "frontend/base/printable.h"
#include "frontend/io/images/image_file.h"
#include "frontend/io/recordings/bag_topics.h"
#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/recordings/ros1/bag_check.h"
#include "frontend/io/recordings/ros1/bag_messages.h"
#include "frontend/io/tables/growing_stamps.h"

namespace tagtwist::internal {
namespace {

using Topics = std::vector<std::string>;

int64_t ToNs(const ros::Time& time) { return static_cast<int64_t>(time.toNSec()); }

// Stamps of the messages on a topic: their headers', or, where never set, the arrivals'.
class Stamps {
 public:
  void Add(int64_t header_ns, const rosbag::MessageInstance& instance) {
    headers_ns_.push_back(header_ns);
    arrivals_ns_.push_back(ToNs(instance.getTime()));
  }
  const std::vector<int64_t>& Get() const {
    const bool set =
        std::any_of(headers_ns_.begin(), headers_ns_.end(), [](int64_t t_ns) { return t_ns != 0; });
    return set ? headers_ns_ : arrivals_ns_;
  }

 private:
  std::vector<int64_t> headers_ns_, arrivals_ns_;
};

Topics TopicsThat(const rosbag::Bag& bag, bool (*fits)(const std::string&)) {
  Topics out;
  rosbag::View all(bag);
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    if (fits(connection->datatype)) out.push_back(connection->topic);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// The samples of a topic. Those that say nothing, or whose stamps do not grow, are passed over and
// noted.
template <typename Sample, typename Convert>
std::vector<Sample> ReadSamples(const rosbag::Bag& bag, const std::string& topic,
                                const Convert& convert, std::vector<std::string>* notes) {
  std::vector<Sample> out, all;
  rosbag::View view(bag, rosbag::TopicQuery(topic));
  Stamps stamps;
  size_t passed_over = 0;
  for (const rosbag::MessageInstance& instance : view) {
    const std::optional<Sample> sample = convert(instance);
    passed_over += sample ? 0 : 1;
    if (!sample) continue;
    stamps.Add(sample->t_ns, instance);
    all.push_back(*sample);
  }
  const size_t count = passed_over + all.size();
  for (size_t i = 0; i < all.size(); ++i) {
    all[i].t_ns = stamps.Get()[i];
    const bool grows = out.empty() || all[i].t_ns > out.back().t_ns;
    passed_over += grows ? 0 : 1;
    if (grows) out.push_back(all[i]);
  }
  if (passed_over > 0) {
    notes->push_back(bag.getFileName() + ": passed over " + std::to_string(passed_over) + " of " +
                     std::to_string(count) + " messages on " + Printable(topic) +
                     ": without a pose or numbers, or out of order");
  }
  return out;
}

std::string OneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Error Damaged(const std::string& path, const std::exception& fault) {
  return Error{path + ": a damaged bag, or one whose recording was not ended: " +
               Printable(OneLine(fault.what()))};
}

class BagSource : public DataSource {
 public:
  BagSource(std::string path, const DataSourceOptions& options)
      : path_(std::move(path)), options_(options) {}

  // May throw.
  Status Open() {
    bag_.open(path_, rosbag::bagmode::Read);
    const auto chosen = ChooseImageTopic(TopicsThat(bag_, IsRos1Image), options_.topic);
    if (!chosen) return Error{path_ + ": " + chosen.error().message};
    topic_ = *chosen;
    view_.addQuery(bag_, rosbag::TopicQuery(topic_));
    if (const auto read = ReadStamps(); !read) return read;
    const Topics imus = TopicsThat(bag_, IsRos1Imu);
    if (imus.size() == 1) imu_ = ReadSamples<ImuSample>(bag_, imus.front(), ReadRos1Imu, &notes_);
    if (const auto read = ReadTruth(); !read) return read;
    at_ = view_.begin();
    return Ok();
  }

  Result<std::optional<Frame>> Next() override {
    if (next_ == stamps_ns_.size()) return std::optional<Frame>();
    Frame frame;
    frame.t_ns = stamps_ns_[next_];
    frame.name = NameOf(kept_[next_]);
    try {
      for (; position_ < kept_[next_]; ++position_) ++at_;  // passed over
      ++next_;
      ++position_;
      if (options_.read_images) {
        auto image = ReadRos1Image(*at_, options_.limits, &frame.image_problem);
        if (!image) return Error{frame.name + ": " + image.error().message};
        frame.image = std::move(*image);
      }
      ++at_;
    } catch (const std::exception& fault) {
      return Damaged(path_, fault);
    }
    if (!frame.image.empty()) {
      if (auto fault = size_guard_.Check(frame.image, frame.name)) return *fault;
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
  Status ReadTruth() {
    auto truth = ChooseTruth(TopicsThat(bag_, IsRos1Pose), TopicsThat(bag_, IsRos1Transforms),
                             options_.truth_topic);
    if (!truth) return Error{path_ + ": " + truth.error().message};
    if (!truth->note.empty()) notes_.push_back(path_ + ": " + truth->note);
    truth_origin_ = truth->Origin();
    if (truth->name.empty()) return Ok();
    if (truth->child.empty()) {
      truth_ = ReadSamples<TruthSample>(bag_, truth->name, ReadRos1Pose, &notes_);
      return Ok();
    }
    TransformsOfFrame transforms(*truth);
    rosbag::View view(bag_, rosbag::TopicQuery(truth->name));
    for (const rosbag::MessageInstance& instance : view)
      transforms.Add(ReadRos1Transforms(instance));
    auto taken = transforms.Take();
    if (!taken) return Error{path_ + ": " + taken.error().message};
    truth_ = std::move(*taken);
    return Ok();
  }
  Status ReadStamps() {
    Stamps stamps;
    std::vector<size_t> readable;
    size_t count = 0;
    for (const rosbag::MessageInstance& instance : view_) {
      if (const auto t_ns = Ros1ImageStamp(instance)) {
        stamps.Add(*t_ns, instance);
        readable.push_back(count);
      }
      ++count;
    }
    const auto growing = KeepGrowing(stamps.Get());
    if (!growing) return Error{path_ + ": " + Printable(topic_) + ": " + growing.error().message};
    for (const size_t i : growing->kept) {
      kept_.push_back(readable[i]);
      stamps_ns_.push_back(stamps.Get()[i]);
    }
    if (readable.size() < count) {
      notes_.push_back(path_ + ": passed over " + std::to_string(count - readable.size()) + " of " +
                       std::to_string(count) + " messages on " + Printable(topic_) +
                       " that do not decode");
    }
    if (!growing->All()) {
      notes_.push_back(path_ + ": " +
                       PassedOverText(*growing, "messages on " + topic_,
                                      "message " + std::to_string(growing->first_passed_over)));
    }
    return Ok();
  }
  std::string path_, topic_, truth_origin_;
  DataSourceOptions options_;
  rosbag::Bag bag_;
  rosbag::View view_;
  rosbag::View::iterator at_;
  std::vector<int64_t> stamps_ns_;
  std::vector<size_t> kept_;  // the frames' messages on the topic
  std::vector<std::string> notes_;
  std::vector<TruthSample> truth_;
  std::vector<ImuSample> imu_;
  size_t next_ = 0, position_ = 0;  // frames handed out, messages passed
  ImageSizeGuard size_guard_;
};

}  // namespace

Result<RosCameraInfo> ReadRos1CameraInfo(const std::string& path, const std::string& topic,
                                         const Limits& limits) {
  if (const auto sound = CheckBagRecords(path, limits); !sound) return sound.error();
  console_bridge::noOutputHandler();
  try {
    const rosbag::Bag bag(path, rosbag::bagmode::Read);
    const auto chosen = ChooseCameraTopic(TopicsThat(bag, IsRos1CameraInfo), topic);
    if (!chosen) return Error{path + ": " + chosen.error().message};
    rosbag::View view(bag, rosbag::TopicQuery(*chosen));
    for (const rosbag::MessageInstance& instance : view) {
      if (auto info = ReadRos1CameraInfoMessage(instance)) return std::move(*info);
    }
    return Error{path + ": no message on " + *chosen + " decodes"};
  } catch (const std::exception& fault) {
    return Damaged(path, fault);
  }
}

Result<std::unique_ptr<DataSource>> OpenBagSource(const std::string& path,
                                                  const DataSourceOptions& options) {
  if (options.use_detections)
    return Error{path + ": a bag has no detections to use: leave out --use_detections"};
  if (const auto sound = CheckBagRecords(path, options.limits); !sound) return sound.error();
  console_bridge::noOutputHandler();  // rosbag would print besides
  try {
    auto source = std::make_unique<BagSource>(path, options);
    if (const auto opened = source->Open(); !opened) return opened.error();
    return std::unique_ptr<DataSource>(std::move(source));
  } catch (const std::exception& fault) {
    return Damaged(path, fault);
  }
}

}  // namespace tagtwist::internal
