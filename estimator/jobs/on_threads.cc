#include "estimator/jobs/on_threads.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "estimator/jobs/in_order.h"

namespace tagtwist::internal {
namespace {

using Work = std::function<void(std::size_t, std::size_t)>;

// One call: `pieces` ranges, taken one by one. Guarded by the pool's mutex.
struct Call {
  std::size_t count, pieces;
  const Work* work;
  std::size_t taken = 0, done = 0;
  std::exception_ptr failure = nullptr;
};

// Threads that wait for work until the pool ends.
class ThreadPool {
 public:
  explicit ThreadPool(int helpers) {
    for (int i = 0; i < helpers; ++i) threads_.emplace_back([this] { Help(); });
  }
  ~ThreadPool() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_over_ = true;
    }
    news_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  // Until all of the call is done; the caller works too.
  void Run(std::size_t count, const Work& work) {
    constexpr std::size_t kPiecesAThread = 4;  // cores that are busy elsewhere are not waited for
    Call call{count, std::min(count, kPiecesAThread * (threads_.size() + 1)), &work};
    std::unique_lock<std::mutex> lock(mutex_);
    const auto at = calls_.insert(calls_.end(), &call);
    news_.notify_all();
    while (call.taken < call.pieces) TakePiece(&call, &lock);
    calls_.erase(at);
    news_.wait(lock, [&] { return call.done == call.pieces; });
    if (call.failure) std::rethrow_exception(call.failure);
  }

 private:
  void Help() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      Call* call = nullptr;
      news_.wait(lock, [&] { return is_over_ || (call = Open()) != nullptr; });
      if (call == nullptr) return;
      TakePiece(call, &lock);
    }
  }

  Call* Open() const {
    for (Call* call : calls_) {
      if (call->taken < call->pieces) return call;
    }
    return nullptr;
  }

  // The lock is open while the piece is worked on.
  void TakePiece(Call* call, std::unique_lock<std::mutex>* lock) {
    const std::size_t piece = call->taken++;
    const std::size_t first = call->count * piece / call->pieces;
    const std::size_t last = call->count * (piece + 1) / call->pieces;
    std::exception_ptr failure;
    lock->unlock();
    try {
      (*call->work)(first, last);
    } catch (...) {
      failure = std::current_exception();
    }
    lock->lock();
    if (failure && !call->failure) call->failure = failure;
    if (++call->done == call->pieces) news_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable news_;  // a call came, one is done, or all is over
  std::list<Call*> calls_;        // guarded by the mutex, as is what they point to
  bool is_over_ = false;          // guarded by the mutex
  std::vector<std::thread> threads_;
};

}  // namespace

ForRanges OnThreads(int threads) {
  const int used = std::min(threads, ResolveThreads(0));
  if (used < 2) return InOneRange;
  const auto pool = std::make_shared<ThreadPool>(used - 1);
  return [pool](std::size_t count, const Work& work) {
    if (count > 0) pool->Run(count, work);
  };
}

}  // namespace tagtwist::internal
