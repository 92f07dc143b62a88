// Peer over Fast DDS without a ROS installation: a reader of topics, and a client of services with
// the mapping of rmw_fastrtps. Messages are CDR bytes; the test encodes and decodes them.
//
// Standard input, one command per line:
//   listen TOPIC TYPE SECONDS        prints the number of messages and the gap percentiles, ms
//   open NAME REQUEST RQTYPE REPLY RRTYPE   opens a client
//   call NAME SECONDS HEX            prints the reply as hex, or "timeout"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/common/WriteParams.h>

using namespace eprosima::fastdds::dds;
using namespace eprosima::fastrtps::rtps;
using Clock = std::chrono::steady_clock;
using Bytes = std::vector<uint8_t>;

// Type whose value is the serialised message.
class Raw : public TopicDataType {
 public:
  explicit Raw(const std::string &name) {
    setName(name.c_str());
    m_typeSize = 4096;
    m_isGetKeyDefined = false;
  }
  bool serialize(void *data, SerializedPayload_t *payload) override {
    const auto &bytes = *static_cast<Bytes *>(data);
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<uint32_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), payload->data);
    return true;
  }
  bool deserialize(SerializedPayload_t *payload, void *data) override {
    static_cast<Bytes *>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void *data) override {
    return [data] { return static_cast<uint32_t>(static_cast<Bytes *>(data)->size()); };
  }
  void *createData() override { return new Bytes(); }
  void deleteData(void *data) override { delete static_cast<Bytes *>(data); }
  bool getKey(void *, InstanceHandle_t *, bool) override { return false; }
};

class Peer {
 public:
  Peer() {
    auto *factory = DomainParticipantFactory::get_instance();
    participant_ = factory->create_participant(0, PARTICIPANT_QOS_DEFAULT);
    publisher_ = participant_->create_publisher(PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  }
  DataReader *reader(const std::string &topic, const std::string &type) {
    DataReaderQos qos = DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
    qos.history().kind = KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 1000;
    qos.endpoint().history_memory_policy = PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return subscriber_->create_datareader(named(topic, type), qos);
  }
  DataWriter *writer(const std::string &topic, const std::string &type) {
    DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
    qos.endpoint().history_memory_policy = PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return publisher_->create_datawriter(named(topic, type), qos);
  }

 private:
  Topic *named(const std::string &topic, const std::string &type) {
    TypeSupport(new Raw(type)).register_type(participant_);
    return participant_->create_topic(topic, type, TOPIC_QOS_DEFAULT);
  }
  DomainParticipant *participant_;
  Publisher *publisher_;
  Subscriber *subscriber_;
};

struct Client {
  DataWriter *requests;
  DataReader *replies;
};

static std::string hex(const Bytes &bytes) {
  std::string text;
  char two[3];
  for (uint8_t byte : bytes) {
    std::snprintf(two, sizeof two, "%02x", byte);
    text += two;
  }
  return text;
}

static Bytes unhex(const std::string &text) {
  Bytes bytes;
  for (size_t at = 0; at + 1 < text.size(); at += 2)
    bytes.push_back(static_cast<uint8_t>(std::stoul(text.substr(at, 2), nullptr, 16)));
  return bytes;
}

static void listen(Peer &peer, std::istringstream &words) {
  std::string topic, type;
  double seconds = 0;
  words >> topic >> type >> seconds;
  DataReader *reader = peer.reader(topic, type);
  std::vector<Clock::time_point> times;
  Bytes bytes;
  SampleInfo info;
  // The first second is discovery.
  auto begin = Clock::now() + std::chrono::seconds(1);
  auto end = begin + std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000.0));
  while (Clock::now() < end) {
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK)
      if (info.valid_data && Clock::now() >= begin) times.push_back(Clock::now());
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  std::vector<double> gaps;
  for (size_t n = 1; n < times.size(); ++n)
    gaps.push_back(std::chrono::duration<double, std::milli>(times[n] - times[n - 1]).count());
  std::sort(gaps.begin(), gaps.end());
  auto at = [&](double share) {
    return gaps.empty() ? -1.0 : gaps[size_t(share * (gaps.size() - 1))];
  };
  std::printf("%zu %.3f %.3f %.3f ", times.size(), at(0.5), at(0.99), at(1.0));
  std::printf("%s\n", hex(bytes).c_str());
}

static void call(Client &client, std::istringstream &words) {
  double seconds = 0;
  std::string text;
  words >> seconds >> text;
  Bytes request = unhex(text);
  WriteParams parameters;
  parameters.related_sample_identity().writer_guid() = client.replies->guid();
  client.requests->write(&request, parameters);
  auto sequence = parameters.sample_identity().sequence_number();
  auto end = Clock::now() + std::chrono::duration<double>(seconds);
  Bytes reply;
  SampleInfo info;
  while (Clock::now() < end) {
    while (client.replies->take_next_sample(&reply, &info) == ReturnCode_t::RETCODE_OK) {
      const auto &to = info.related_sample_identity;
      bool is_ours = to.writer_guid() == client.replies->guid() ||
                     to.writer_guid() == client.requests->guid();
      if (info.valid_data && is_ours && to.sequence_number() == sequence) {
        std::printf("%s\n", hex(reply).c_str());
        return;
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::printf("timeout\n");
}

int main() {
  Peer peer;
  std::map<std::string, Client> clients;
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string verb, name;
    words >> verb;
    if (verb == "listen") {
      listen(peer, words);
    } else if (verb == "open") {
      std::string request, request_type, reply, reply_type;
      words >> name >> request >> request_type >> reply >> reply_type;
      Client client{peer.writer(request, request_type), peer.reader(reply, reply_type)};
      PublicationMatchedStatus asks;
      SubscriptionMatchedStatus answers;
      for (int tries = 0; tries < 1000; ++tries) {
        client.requests->get_publication_matched_status(asks);
        client.replies->get_subscription_matched_status(answers);
        if (asks.current_count > 0 && answers.current_count > 0) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      clients[name] = client;
      bool is_open = asks.current_count > 0 && answers.current_count > 0;
      std::printf("%s\n", is_open ? "open" : "no server");
    } else if (verb == "call") {
      words >> name;
      call(clients.at(name), words);
    }
    std::fflush(stdout);
  }
  // The participant ends with the process.
  std::_Exit(0);
}
