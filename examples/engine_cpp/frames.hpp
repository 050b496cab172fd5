// The frame loop, with two frames in flight.
#pragma once
#include "device.hpp"
#include <memory>

class Frames {
public:
    static constexpr uint32_t IN_FLIGHT = 2;
    // What is done with a frame's scores when its commands have run.
    using Done = std::function<void(const float* scores)>;
    // Records a frame: its number among those in flight, and where its scores go.
    using Record = std::function<Done(VkCommandBuffer cmd, uint32_t frame, VkBuffer scores)>;

    Frames(const Device& device, uint32_t most_scores);
    ~Frames();
    Frames(const Frames&) = delete;

    // Records and submits one more frame, as soon as one of those in flight has ended.
    void next(const Record& record);
    // Waits for all of them.
    void finish();

private:
    struct Frame {
        VkCommandBuffer cmd;
        VkFence fence;
        std::unique_ptr<Buffer> scores;
        Done done;
    };

    void wait(Frame& frame);

    const Device& device;
    Frame frames[IN_FLIGHT];
    uint32_t turn = 0;
};
