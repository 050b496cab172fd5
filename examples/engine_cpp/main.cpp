// An engine that lets klieg light its scene. It has a Vulkan device, a frame loop and a renderer of
// its own, and uses klieg at all three levels. At level 1 klieg draws the scene by itself, of the
// engine's arrays: here that is what level 2 is compared with. At level 2 klieg measures lights
// against the engine's G-buffer, inside the engine's frames. At level 3 it judges pictures that the
// engine renders there, with its own shading and shadows.
//
// The engine saves its picture under one light from the viewer and under the lights that were found
// at levels 2 and 3. It succeeds when levels 1 and 2 agree, both searches have found better lights,
// and the validation layer is silent.
#include "frames.hpp"
#include "lighting.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <png.h>

namespace {

// How far the scores of levels 1 and 2 may be apart: the G-buffer's formats round.
constexpr float TOLERANCE = 2e-3f;

struct Options {
    VkExtent2D size{480, 360};
    uint32_t generations = 30;
    uint32_t cycles = 1; // how often all is made and destroyed
    bool validate = false;
    bool device_first = false; // destroys the device before what klieg has made
    std::string out = ".";
};

Options parse(int count, char** arguments) {
    Options options;
    for (int i = 1; i < count; ++i) {
        std::string name = arguments[i];
        auto value = [&]() -> std::string { return ++i < count ? arguments[i] : ""; };
        bool good = true;
        if (name == "--size") {
            good = std::sscanf(value().c_str(), "%ux%u", &options.size.width,
                               &options.size.height) == 2;
        } else if (name == "--generations") {
            good = std::sscanf(value().c_str(), "%u", &options.generations) == 1;
        } else if (name == "--cycles") {
            good = std::sscanf(value().c_str(), "%u", &options.cycles) == 1;
        } else if (name == "--order") {
            std::string order = value();
            options.device_first = order == "device-first";
            good = options.device_first || order == "klieg-first";
        } else if (name == "--out") {
            options.out = value();
        } else if (name == "--validate") {
            options.validate = true;
        } else {
            good = false;
        }
        if (!good) {
            throw std::runtime_error(
                "usage: engine [--size WxH] [--generations N] [--cycles N] [--out FOLDER] "
                "[--order klieg-first|device-first] [--validate]");
        }
    }
    return options;
}

class Engine {
public:
    explicit Engine(const Options& options)
        : options(options), scene(make_scene()),
          camera({2.4f, 3.6f, 6.6f}, {0.1f, 0.35f, 0}, aspect(options.size)) {
        klieg_features features;
        klieg_feature_chain chain;
        device = std::make_unique<Device>(options.validate, [&](VkDeviceCreateInfo& info) {
            ask(klieg_enable_features(KLIEG_NEEDS_SCENE, &info, &chain));
            ask(klieg_enabled_features(&info, &features));
        });
        renderer = std::make_unique<Renderer>(*device, scene, options.size, Frames::IN_FLIGHT);
        frames = std::make_unique<Frames>(*device, Search::POPULATION);
        lighting = std::make_unique<Lighting>(*device, features, scene, camera, *renderer,
                                              Search::POPULATION, Search::LIGHTS);
    }

    ~Engine() {
        frames.reset();
        if (options.device_first) {
            lighting->forget_device();
        } else {
            lighting.reset();
        }
        renderer.reset();
        device.reset();
    }

    // Whether all is as it should be.
    bool run() {
        bool good = compare_levels();
        save("headlight.png");
        good &= design(Level::SURFACE, "surface");
        good &= design(Level::PICTURES, "pictures");
        return good;
    }

private:
    static float aspect(VkExtent2D size) { return float(size.width) / float(size.height); }

    // Records a frame that shows the picture under the lights `shown` and measures `asked`.
    void record(VkCommandBuffer cmd, uint32_t frame, Level level, const Rigs& asked,
                VkBuffer scores) {
        renderer->draw_surface(cmd, frame);
        lighting->record_view(level, cmd);
        std::vector<Rig> rigs = lighting->in_world(level, shown);
        if (level == Level::PICTURES) {
            for (const Rig& rig : lighting->in_world(level, asked)) rigs.push_back(rig);
        }
        renderer->set(frame, camera, rigs);
        renderer->draw_pictures(cmd, frame, rigs);
        if (asked.count() > 0) lighting->record(level, cmd, asked, 1, scores);
    }

    // The scores of a frame that is waited for.
    std::vector<float> score(Level level, const Rigs& rigs) {
        std::vector<float> result;
        frames->next([&](VkCommandBuffer cmd, uint32_t frame, VkBuffer buffer) -> Frames::Done {
            record(cmd, frame, level, rigs, buffer);
            return [&](const float* scores) { result.assign(scores, scores + rigs.count()); };
        });
        frames->finish();
        return result;
    }

    // Searches for a generation at a time: it is measured in one frame, and its scores are there
    // when that frame has ended. The frames in between only draw.
    Rigs search(Level level) {
        Search search(1);
        uint32_t generation = 0;
        bool measuring = false;
        while (generation < options.generations) {
            frames->next([&](VkCommandBuffer cmd, uint32_t frame, VkBuffer buffer) -> Frames::Done {
                Rigs asked;
                if (!measuring) asked = search.wanted();
                record(cmd, frame, level, asked, buffer);
                if (measuring) return nullptr;
                measuring = true;
                return [&, count = asked.count()](const float* scores) {
                    search.tell(scores, count);
                    shown = search.best();
                    measuring = false;
                    ++generation;
                };
            });
        }
        frames->finish();
        return search.best();
    }

    bool compare_levels() {
        bool agree = true;
        float apart = 0;
        for (const Rigs& rigs : {headlight(), Search(2).wanted()}) {
            std::vector<float> expected = lighting->score_scene(rigs);
            std::vector<float> found = score(Level::SURFACE, rigs);
            for (uint32_t i = 0; i < rigs.count(); ++i) {
                float difference = std::fabs(found[i] - expected[i]);
                apart = std::max(apart, difference);
                agree &= difference < TOLERANCE; // neither is NaN then
            }
        }
        std::cout << "levels 1 and 2 " << (agree ? "agree" : "differ")
                  << ": their scores are at most " << apart << " apart\n";
        return agree;
    }

    bool design(Level level, const std::string& name) {
        float before = score(level, headlight())[0];
        shown = search(level);
        float after = score(level, shown)[0];
        save(name + ".png");
        std::cout << name << ": headlight " << before << ", designed " << after << "\n";
        return after < before;
    }

    // Draws and saves what is shown.
    void save(const std::string& name) {
        score(Level::SURFACE, {});
        std::vector<uint8_t> texels = renderer->read_picture();
        png_image image{};
        image.version = PNG_IMAGE_VERSION;
        image.width = options.size.width;
        image.height = options.size.height;
        image.format = PNG_FORMAT_RGBA;
        std::string path = options.out + "/" + name;
        if (!png_image_write_to_file(&image, path.c_str(), 0, texels.data(), 0, nullptr)) {
            throw std::runtime_error(path + ": " + image.message);
        }
    }

    const Options& options;
    Scene scene;
    Camera camera;
    std::unique_ptr<Lighting> lighting; // may outlive the device
    std::unique_ptr<Device> device;
    std::unique_ptr<Renderer> renderer;
    std::unique_ptr<Frames> frames;
    Rigs shown = headlight();
};

// Whether the validation layer was silent. Where the device goes first, it names what klieg leaves.
bool silent(const Options& options) {
    size_t complaints = 0;
    for (const std::string& message : validation_messages) {
        bool left = options.device_first &&
                    message.find("VUID-vkDestroyDevice-device") != std::string::npos;
        if (!left) std::cerr << message << "\n";
        complaints += !left;
    }
    return complaints == 0;
}

} // namespace

int main(int count, char** arguments) {
    try {
        Options options = parse(count, arguments);
        bool good = true;
        for (uint32_t i = 0; i < options.cycles; ++i) good &= Engine(options).run();
        return silent(options) && good ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return EXIT_FAILURE;
    }
}
