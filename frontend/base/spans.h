#pragma once

namespace tagtwist {

/// Told when work of a name begins and ends, by the thread that does it: what a thread begins last
/// it ends first. Several threads may call at the same time. Whoever hands it down has the clock.
class SpanObserver {
 public:
  virtual ~SpanObserver() = default;
  /// `name` stays where it is as long as the observer lives.
  virtual void Begin(const char* name) = 0;
  virtual void End() noexcept = 0;
};

/// Work of that name, for as long as this lives. Without an observer it costs nothing.
class Span {
 public:
  Span(SpanObserver* observer, const char* name) : observer_(observer) {
    if (observer_ != nullptr) observer_->Begin(name);
  }
  ~Span() {
    if (observer_ != nullptr) observer_->End();
  }
  Span(const Span&) = delete;
  Span& operator=(const Span&) = delete;

 private:
  SpanObserver* observer_;
};

/// Stages of work, one after the other: each ends where the next begins, the last with this.
class Stages {
 public:
  explicit Stages(SpanObserver* observer) : observer_(observer) {}
  ~Stages() { Finish(); }
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;

  void Next(const char* name) {
    Finish();
    if (observer_ == nullptr) return;
    observer_->Begin(name);
    is_open_ = true;
  }

 private:
  void Finish() {
    if (is_open_) observer_->End();
    is_open_ = false;
  }

  SpanObserver* observer_;
  bool is_open_ = false;
};

}  // namespace tagtwist
