#include "frames.hpp"

Frames::Frames(const Device& device, uint32_t most_scores) : device(device) {
    for (Frame& frame : frames) {
        VkCommandBufferAllocateInfo buffers{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        buffers.commandPool = device.pool;
        buffers.commandBufferCount = 1;
        check(vkAllocateCommandBuffers(device.handle, &buffers, &frame.cmd),
              "vkAllocateCommandBuffers");
        VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr,
                                VK_FENCE_CREATE_SIGNALED_BIT};
        check(vkCreateFence(device.handle, &fence, nullptr, &frame.fence), "vkCreateFence");
        VkDeviceSize size = most_scores * sizeof(float);
        frame.scores = std::make_unique<Buffer>(device, size, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    }
}

Frames::~Frames() {
    vkDeviceWaitIdle(device.handle);
    for (Frame& frame : frames) {
        vkDestroyFence(device.handle, frame.fence, nullptr);
        vkFreeCommandBuffers(device.handle, device.pool, 1, &frame.cmd);
    }
}

void Frames::next(const Record& record) {
    uint32_t number = turn++ % IN_FLIGHT;
    Frame& frame = frames[number];
    wait(frame);
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(frame.cmd, &begin), "vkBeginCommandBuffer");
    frame.done = record(frame.cmd, number, frame.scores->handle);
    memory_barrier(frame.cmd, COPY_WRITE, HOST_READ);
    check(vkEndCommandBuffer(frame.cmd), "vkEndCommandBuffer");
    check(vkResetFences(device.handle, 1, &frame.fence), "vkResetFences");
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &frame.cmd;
    check(vkQueueSubmit(device.queue, 1, &submit, frame.fence), "vkQueueSubmit");
}

void Frames::finish() {
    for (uint32_t i = 0; i < IN_FLIGHT; ++i) wait(frames[(turn + i) % IN_FLIGHT]);
}

void Frames::wait(Frame& frame) {
    check(vkWaitForFences(device.handle, 1, &frame.fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    if (frame.done) frame.done(static_cast<const float*>(frame.scores->mapped));
    frame.done = nullptr;
}
