#pragma once
#include <fcntl.h>
#include <unistd.h>

#include <string>

namespace tagtwist::internal {

/// A file that is open to be read, and is closed with its scope.
class Descriptor {
 public:
  explicit Descriptor(const std::string& path)
      : number_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }  // -1: it cannot be opened, as errno says

 private:
  int number_;
};

}  // namespace tagtwist::internal
