#pragma once
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace tagtwist {

/// std::optional<T> whose value lies apart: where there is none it takes the room of a pointer. For
/// large values that many objects could have and few do. Copies are deep.
template <typename T>
class OptionalApart {
  template <typename U>
  using IfValue = std::enable_if_t<!std::is_same_v<std::decay_t<U>, OptionalApart> &&
                                   !std::is_same_v<std::decay_t<U>, std::nullopt_t> &&
                                   std::is_constructible_v<T, U>>;

 public:
  OptionalApart() = default;
  OptionalApart(std::nullopt_t) {}  // NOLINT(google-explicit-constructor)
  template <typename U, typename = IfValue<U>>
  OptionalApart(U&& value)  // NOLINT(google-explicit-constructor)
      : value_(std::make_unique<T>(std::forward<U>(value))) {}
  OptionalApart(const OptionalApart& other) : value_(CopyOf(other)) {}
  OptionalApart(OptionalApart&&) noexcept = default;
  OptionalApart& operator=(const OptionalApart& other) {
    if (this != &other) value_ = CopyOf(other);
    return *this;
  }
  OptionalApart& operator=(OptionalApart&&) noexcept = default;
  ~OptionalApart() = default;

  template <typename... Args>
  T& emplace(Args&&... args) {
    value_ = std::make_unique<T>(std::forward<Args>(args)...);
    return *value_;
  }
  void reset() { value_.reset(); }

  bool has_value() const { return value_ != nullptr; }
  explicit operator bool() const { return has_value(); }
  const T& operator*() const { return *value_; }
  T& operator*() { return *value_; }
  const T* operator->() const { return value_.get(); }
  T* operator->() { return value_.get(); }
  T value_or(const T& other) const { return value_ ? *value_ : other; }

  friend bool operator==(const OptionalApart& a, const OptionalApart& b) {
    return a.value_ && b.value_ ? *a.value_ == *b.value_ : !a.value_ && !b.value_;
  }

 private:
  static std::unique_ptr<T> CopyOf(const OptionalApart& other) {
    return other.value_ ? std::make_unique<T>(*other.value_) : nullptr;
  }

  std::unique_ptr<T> value_;
};

}  // namespace tagtwist
