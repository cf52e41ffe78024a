// Random episodes of a simulator, each of whose messages must be in the part of its episode, and
// sources that are late together while another one goes on.
#include "tools/bags/time_jumps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <random>
#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

struct Sent {
  std::string source;
  TimeJumps::Kind kind;
  double stamp_s, received_s;
  std::size_t episode = 0;
};

struct Publisher {
  std::string source;
  TimeJumps::Kind kind;
  double rate_hz;
};

// An episode that was recorded from `start_s` on.
struct Episode {
  std::size_t number;
  double start_s, length_s;
};

void publish(const Publisher& publisher, double first_s, const Episode& episode,
             std::vector<Sent>* sent) {
  for (double s = first_s; s < episode.length_s; s += 1 / publisher.rate_hz) {
    sent->push_back(
        {publisher.source, publisher.kind, 10 + s, episode.start_s + s, episode.number});
  }
}

void sortByReceipt(std::vector<Sent>* sent) {
  std::stable_sort(sent->begin(), sent->end(),
                   [](const Sent& a, const Sent& b) { return a.received_s < b.received_s; });
}

TimeJumps jumpsOf(const std::vector<Sent>& sent) {
  TimeJumps jumps;
  for (const Sent& message : sent) {
    jumps.look(message.source, message.kind, ros::Time(message.stamp_s),
               ros::Time(message.received_s));
  }
  jumps.finish();
  return jumps;
}

class RandomEpisodes {
 public:
  explicit RandomEpisodes(unsigned seed) : random_(seed), latency_s_(one({0, 0.03, 0.1})) {
    using Kind = TimeJumps::Kind;
    publishers_ = {{frameSource("finger"), Kind::kPose, one({10, 30, 50, 100})},
                   {frameSource("camera"), Kind::kPose, one({5, 10, 30})},
                   {jointSource("gripper"), Kind::kPose, one({5, 20, 125})},
                   {topicSource("/cloth"), Kind::kMesh, one({5, 10, 30})},
                   {topicSource("/rag"), Kind::kMesh, one({3, 10})}};
  }

  std::vector<Sent> sent() {
    std::vector<Sent> all;
    const std::size_t episodes = 2 + random_() % 4;
    double start_s = 1000;
    for (std::size_t episode = 0; episode < episodes; ++episode) {
      const double length_s = one({0.6, 1.5, 3, 4.2});
      for (const Publisher& publisher : publishers_) {
        const std::size_t first = all.size();
        publish(publisher, upTo(1 / publisher.rate_hz), {episode, start_s, length_s}, &all);
        const double latency_s = upTo(latency_s_);
        for (std::size_t i = first; i < all.size(); ++i) all[i].received_s += latency_s;
      }
      start_s += length_s + one({0.1, 0.5, 1});
    }
    sortByReceipt(&all);
    return all;
  }

 private:
  double one(std::initializer_list<double> values) {
    return values.begin()[random_() % values.size()];
  }
  double upTo(double most) { return most * static_cast<double>(random_()) / 4294967296.0; }

  std::mt19937 random_;
  double latency_s_;
  std::vector<Publisher> publishers_;
};

void expectEpisodes(const std::vector<Sent>& sent, unsigned seed = 0) {
  const TimeJumps jumps = jumpsOf(sent);
  EXPECT_EQ(jumps.all().size(), sent.back().episode) << seed;
  const auto is_elsewhere = [&jumps](const Sent& message) {
    return jumps.partOf(message.source, ros::Time(message.received_s)) != message.episode;
  };
  EXPECT_EQ(std::count_if(sent.begin(), sent.end(), is_elsewhere), 0) << seed;
}

// The sources go back one after the other.
TEST(TimeJumps, EachMessageIsInItsEpisode) {
  for (unsigned seed = 0; seed < 300; ++seed) expectEpisodes(RandomEpisodes(seed).sent(), seed);
}

// Of the second episode, the mesh that goes back first has only two messages.
TEST(TimeJumps, AShortEpisodeAfterALongOne) {
  using Kind = TimeJumps::Kind;
  for (const double gap_s : {0.1, 0.5}) {
    std::vector<Sent> sent;
    for (const Episode& episode :
         {Episode{0, 1000, 4.2}, {1, 1004.2 + gap_s, 0.6}, {2, 1004.8 + 2 * gap_s, 0.6}}) {
      publish({topicSource("/rag"), Kind::kMesh, 3}, 0.004, episode, &sent);
      publish({frameSource("finger"), Kind::kPose, 100}, 0.008, episode, &sent);
      publish({frameSource("camera"), Kind::kPose, 30}, 0.015, episode, &sent);
    }
    sortByReceipt(&sent);
    expectEpisodes(sent);
  }
}

// Two sources stand for a while and send late what they have, so their stamps fall together.
TEST(TimeJumps, SourcesThatAreLateTogetherAreNoJumpWhileOneGoesOn) {
  for (const double late_s : {0.6, 1.5, 3.0}) {
    for (const double until_s : {4.2, 5.5, 8.0}) {
      std::vector<Sent> sent;
      for (int i = 0; i < 200; ++i) {
        const double s = 0.05 * i, behind_s = s > 4 && s < until_s ? late_s : 0;
        sent.push_back({frameSource("finger"), TimeJumps::Kind::kPose, 10 + s - behind_s, s});
        sent.push_back({frameSource("camera"), TimeJumps::Kind::kPose, 10 + s - behind_s, s});
        sent.push_back({frameSource("base"), TimeJumps::Kind::kPose, 10 + s, s});
      }
      for (Sent& message : sent) message.received_s += 1000;
      EXPECT_EQ(jumpsOf(sent).all().size(), 0U) << late_s << ' ' << until_s;
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
