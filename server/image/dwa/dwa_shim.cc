#include "server/image/dwa/dwa_shim.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <stdexcept>
#include <vector>

namespace
{
/* A file that is only in memory. */
class memory_out : public Imf::OStream
{
  public:
    explicit memory_out(std::vector<char> &bytes) : Imf::OStream("memory"), bytes(bytes)
    {
    }
    void write(const char c[], int n) override
    {
        const size_t end = at + static_cast<size_t>(n);
        if (end > bytes.size()) bytes.resize(end);
        std::copy(c, c + n, bytes.begin() + static_cast<std::ptrdiff_t>(at));
        at = end;
    }
    uint64_t tellp() override
    {
        return at;
    }
    void seekp(uint64_t position) override
    {
        at = position;
    }

  private:
    std::vector<char> &bytes;
    size_t at = 0;
};

class memory_in : public Imf::IStream
{
  public:
    explicit memory_in(const std::vector<char> &bytes) : Imf::IStream("memory"), bytes(bytes)
    {
    }
    bool read(char c[], int n) override
    {
        const size_t size = static_cast<size_t>(n);
        if (at > bytes.size() || bytes.size() - at < size) throw std::runtime_error("its end");
        std::memcpy(c, bytes.data() + at, size);
        at += size;
        return at < bytes.size();
    }
    uint64_t tellg() override
    {
        return at;
    }
    void seekg(uint64_t position) override
    {
        at = position;
    }

  private:
    const std::vector<char> &bytes;
    size_t at = 0;
};

class file_in : public Imf::IStream
{
  public:
    explicit file_in(int fd) : Imf::IStream("file"), fd(fd)
    {
    }
    bool read(char c[], int n) override
    {
        int done = 0;
        while (done < n) {
            const ssize_t part =
                pread(fd, c + done, static_cast<size_t>(n - done), static_cast<off_t>(at) + done);
            if (part < 0 && errno == EINTR) continue;
            if (part <= 0) throw std::runtime_error("its end");
            done += static_cast<int>(part);
        }
        at += static_cast<uint64_t>(n);
        return true;
    }
    uint64_t tellg() override
    {
        return at;
    }
    void seekg(uint64_t position) override
    {
        at = position;
    }

  private:
    int fd;
    uint64_t at = 0;
};

/* Writes the rows as a file of one chunk. */
void write_chunk(const dwa_channel *channels, int count, int32_t width_px, int32_t rows,
                 const uint8_t *packed, std::vector<char> &bytes)
{
    Imf::Header header(width_px, rows);
    Imf::FrameBuffer frame;
    size_t row_bytes = 0, offset = 0;
    header.compression() = Imf::DWAA_COMPRESSION;
    for (int c = 0; c < count; c++)
        row_bytes += static_cast<size_t>(width_px) * (channels[c].is_half ? 2 : 4);
    for (int c = 0; c < count; c++) {
        const Imf::PixelType type = channels[c].is_half ? Imf::HALF : Imf::FLOAT;
        const size_t size = channels[c].is_half ? 2 : 4;
        char *base = const_cast<char *>(reinterpret_cast<const char *>(packed)) + offset;
        header.channels().insert(channels[c].name,
                                 Imf::Channel(type, 1, 1, channels[c].is_linear != 0));
        frame.insert(channels[c].name, Imf::Slice(type, base, size, row_bytes));
        offset += static_cast<size_t>(width_px) * size;
    }
    memory_out stream(bytes);
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(rows);
}

dwa_status compress(const dwa_channel *channels, int count, int32_t width_px, int32_t rows,
                    const uint8_t *packed, uint8_t *out, size_t capacity, size_t *size_bytes)
{
    std::vector<char> bytes;
    const char *chunk = nullptr;
    int chunk_bytes = 0;
    write_chunk(channels, count, width_px, rows, packed, bytes);
    memory_in stream(bytes);
    Imf::InputFile file(stream, 0);
    file.rawPixelData(0, chunk, chunk_bytes);
    if (static_cast<size_t>(chunk_bytes) > capacity) return DWA_NO_ROOM;
    std::memcpy(out, chunk, static_cast<size_t>(chunk_bytes));
    *size_bytes = static_cast<size_t>(chunk_bytes);
    return DWA_OK;
}

dwa_status read_file(int fd, const dwa_plane *planes, int count)
{
    file_in stream(fd);
    Imf::InputFile file(stream, 0);
    Imf::FrameBuffer frame;
    const auto window = file.header().dataWindow();
    for (int c = 0; c < count; c++) {
        const size_t row_bytes = static_cast<size_t>(planes[c].stride) * sizeof(float);
        frame.insert(planes[c].name, Imf::Slice::Make(Imf::FLOAT, planes[c].data, window,
                                                      sizeof(float), row_bytes));
    }
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    return DWA_OK;
}
} // namespace

dwa_status dwa_shim_compress(const dwa_channel *channels, int count, int32_t width_px, int32_t rows,
                             const uint8_t *packed, uint8_t *out, size_t capacity,
                             size_t *size_bytes)
{
    try {
        return compress(channels, count, width_px, rows, packed, out, capacity, size_bytes);
    } catch (const std::bad_alloc &) {
        return DWA_NO_MEMORY;
    } catch (...) {
        return DWA_DAMAGED;
    }
}

dwa_status dwa_shim_read(int fd, const dwa_plane *planes, int count)
{
    try {
        return read_file(fd, planes, count);
    } catch (const std::bad_alloc &) {
        return DWA_NO_MEMORY;
    } catch (...) {
        return DWA_DAMAGED;
    }
}
