/*
 * Disk shim: observes what a process writes below one folder, and fails one call of it.
 *
 * Loaded by LD_PRELOAD, it stands before the functions of the C library that change files or sync
 * them, so that writers in C and C++ are seen as well as those in Python. Each call that succeeds
 * is logged in the order in which it happened. Python starts, stops and asks it by ctypes.
 *
 * A record of the log: a line "<op> <number> <offset> <length> <mtime_ns> <path bytes> <other
 * bytes>\n", then path, other path and data.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP;
static char root[PATH_MAX];
static size_t root_length;
static int log_file = -1;
static long calls, failing;
static int failure;
static char failed[PATH_MAX + 32];

#define REAL(name) \
    static __typeof__(&name) real; \
    if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

/* --- control ---------------------------------------------------------------------------- */

void shim_start(const char *folder, const char *log, long fail_at, int code)
{
    pthread_mutex_lock(&lock);
    snprintf(root, sizeof root, "%s/", folder);
    root_length = strlen(root);
    calls = 0;
    failing = fail_at;
    failure = code;
    failed[0] = 0;
    log_file = *log ? (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600) : -1;
    pthread_mutex_unlock(&lock);
}

long shim_stop(void)
{
    pthread_mutex_lock(&lock);
    root_length = 0;
    if (log_file >= 0) syscall(SYS_close, log_file);
    log_file = -1;
    pthread_mutex_unlock(&lock);
    return calls;
}

const char *shim_failed(void) { return failed; }

/* --- paths ------------------------------------------------------------------------------ */

static int is_observed(const char *path)
{
    return root_length && (!strncmp(path, root, root_length) || (strlen(path) == root_length - 1 && !strncmp(path, root, root_length - 1)));
}

static const char *path_of_descriptor(int fd, char *out)
{
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, out, PATH_MAX - 1);
    out[length > 0 ? length : 0] = 0;
    return out;
}

static const char *absolute(int folder, const char *path, char *out)
{
    char base[PATH_MAX];
    if (path[0] == '/') {
        snprintf(out, PATH_MAX, "%s", path);
        return out;
    }
    if (folder == AT_FDCWD) {
        if (!getcwd(base, sizeof base)) base[0] = 0;
    } else {
        path_of_descriptor(folder, base);
    }
    if (!strcmp(path, ".")) snprintf(out, PATH_MAX, "%s", base);
    else if (snprintf(out, PATH_MAX, "%s/%s", base, path) >= PATH_MAX) out[0] = 0;
    return out;
}

/* --- calls ------------------------------------------------------------------------------ */

/* Counts a call, under the lock; returns whether it has to fail, with errno set. */
static int fails(const char *op, const char *path)
{
    calls += 1;
    if (calls != failing) return 0;
    snprintf(failed, sizeof failed, "%s %s", op, path);
    errno = failure;
    return 1;
}

static void write_out(const void *data, size_t length)
{
    while (length) {
        long done = syscall(SYS_write, log_file, data, length);
        if (done <= 0) abort();
        data = (const char *)data + done;
        length -= (size_t)done;
    }
}

static void record(const char *op, const char *path, const char *other, long long offset,
                   const void *data, size_t length, int fd)
{
    struct stat found = {0};
    char head[256];
    if (log_file < 0) return;
    if (fd >= 0) fstat(fd, &found);
    long long time = found.st_mtim.tv_sec * 1000000000LL + found.st_mtim.tv_nsec;
    int size = snprintf(head, sizeof head, "%s %ld %lld %zu %lld %zu %zu\n", op, calls, offset,
                        length, time, strlen(path), strlen(other));
    write_out(head, (size_t)size);
    write_out(path, strlen(path));
    write_out(other, strlen(other));
    if (data) write_out(data, length);
}

/* --- opening ---------------------------------------------------------------------------- */

static int opened(int (*real)(int, const char *, int, ...), int folder, const char *path, int flags, mode_t mode)
{
    char full[PATH_MAX];
    struct stat before;
    if (!root_length || !(flags & (O_WRONLY | O_RDWR | O_CREAT)) || !is_observed(absolute(folder, path, full)))
        return real(folder, path, flags, mode);
    pthread_mutex_lock(&lock);
    int existed = stat(full, &before) == 0;
    int fd = -1;
    if (!fails("open", full)) {
        fd = real(folder, path, flags, mode);
        if (fd >= 0 && !existed) record("create", full, "", 0, NULL, 0, fd);
        else if (fd >= 0 && (flags & O_TRUNC)) record("truncate", full, "", 0, NULL, 0, fd);
    }
    int code = errno;
    pthread_mutex_unlock(&lock);
    errno = code;
    return fd;
}

#define MODE \
    mode_t mode = 0; \
    if (flags & (O_CREAT | O_TMPFILE)) { va_list rest; va_start(rest, flags); mode = va_arg(rest, mode_t); va_end(rest); }

int openat(int folder, const char *path, int flags, ...) { REAL(openat); MODE; return opened(real, folder, path, flags, mode); }
int openat64(int folder, const char *path, int flags, ...) { REAL(openat64); MODE; return opened(real, folder, path, flags, mode); }
int open(const char *path, int flags, ...) { REAL(openat); MODE; return opened(real, AT_FDCWD, path, flags, mode); }
int open64(const char *path, int flags, ...) { REAL(openat64); MODE; return opened(real, AT_FDCWD, path, flags, mode); }
int creat(const char *path, mode_t mode) { return open(path, O_CREAT | O_WRONLY | O_TRUNC, mode); }
int creat64(const char *path, mode_t mode) { return open64(path, O_CREAT | O_WRONLY | O_TRUNC, mode); }

/* Streams write by functions inside the C library, which nobody can stand before. */
static FILE *streamed(FILE *(*real)(const char *, const char *), const char *path, const char *mode)
{
    char full[PATH_MAX];
    if (strpbrk(mode, "wa+") && is_observed(absolute(AT_FDCWD, path, full))) {
        fprintf(stderr, "disk shim: %s is written by a stream, which is not observed\n", full);
        abort();
    }
    return real(path, mode);
}

FILE *fopen(const char *path, const char *mode) { REAL(fopen); return streamed(real, path, mode); }
FILE *fopen64(const char *path, const char *mode) { REAL(fopen64); return streamed(real, path, mode); }

/* --- content ---------------------------------------------------------------------------- */

/* Runs a call on an open file between counting and recording it. */
#define ON_FILE(type, op, call, recorded) \
    char full[PATH_MAX]; \
    if (!root_length || !is_observed(path_of_descriptor(fd, full))) return call; \
    pthread_mutex_lock(&lock); \
    type result = -1; \
    if (!fails(op, full)) { \
        long long at = (long long)lseek(fd, 0, SEEK_CUR); \
        (void)at; \
        result = call; \
        if (result >= 0) recorded; \
    } \
    int code = errno; \
    pthread_mutex_unlock(&lock); \
    errno = code; \
    return result

static long long end_of(int fd, long long at, ssize_t written)
{
    /* In append mode the data stand at the end, wherever the position was. */
    return fcntl(fd, F_GETFL) & O_APPEND ? (long long)lseek(fd, 0, SEEK_CUR) - written : at;
}

ssize_t write(int fd, const void *data, size_t length)
{
    REAL(write);
    ON_FILE(ssize_t, "write", real(fd, data, length),
            record("write", full, "", end_of(fd, at, result), data, (size_t)result, fd));
}

ssize_t pwrite(int fd, const void *data, size_t length, off_t offset)
{
    REAL(pwrite);
    ON_FILE(ssize_t, "write", real(fd, data, length, offset),
            record("write", full, "", offset, data, (size_t)result, fd));
}

ssize_t pwrite64(int fd, const void *data, size_t length, off64_t offset)
{
    REAL(pwrite64);
    ON_FILE(ssize_t, "write", real(fd, data, length, offset),
            record("write", full, "", offset, data, (size_t)result, fd));
}

static void record_vector(const char *path, const struct iovec *parts, int count, long long at, ssize_t length, int fd)
{
    for (int k = 0; k < count && length > 0; k++) {
        size_t size = parts[k].iov_len < (size_t)length ? parts[k].iov_len : (size_t)length;
        record("write", path, "", at, parts[k].iov_base, size, fd);
        at += (long long)size;
        length -= (ssize_t)size;
    }
}

ssize_t writev(int fd, const struct iovec *parts, int count)
{
    REAL(writev);
    ON_FILE(ssize_t, "write", real(fd, parts, count),
            record_vector(full, parts, count, end_of(fd, at, result), result, fd));
}

int ftruncate(int fd, off_t length)
{
    REAL(ftruncate);
    ON_FILE(int, "truncate", real(fd, length), record("truncate", full, "", length, NULL, 0, fd));
}

int ftruncate64(int fd, off64_t length)
{
    REAL(ftruncate64);
    ON_FILE(int, "truncate", real(fd, length), record("truncate", full, "", length, NULL, 0, fd));
}

int fsync(int fd)
{
    REAL(fsync);
    ON_FILE(int, "sync", real(fd), record("sync", full, "", 0, NULL, 0, fd));
}

int fdatasync(int fd)
{
    REAL(fdatasync);
    ON_FILE(int, "sync", real(fd), record("sync", full, "", 0, NULL, 0, fd));
}

/* --- names ------------------------------------------------------------------------------ */

#define ON_NAME(op, call) \
    char full[PATH_MAX]; \
    if (!root_length || !is_observed(absolute(folder, path, full))) return call; \
    pthread_mutex_lock(&lock); \
    int result = -1; \
    if (!fails(op, full)) { \
        result = call; \
        if (result == 0) record(op, full, "", 0, NULL, 0, -1); \
    } \
    int code = errno; \
    pthread_mutex_unlock(&lock); \
    errno = code; \
    return result

int unlink(const char *path) { REAL(unlink); int folder = AT_FDCWD; ON_NAME("unlink", real(path)); }
int rmdir(const char *path) { REAL(rmdir); int folder = AT_FDCWD; ON_NAME("unlink", real(path)); }
int unlinkat(int folder, const char *path, int flags) { REAL(unlinkat); ON_NAME("unlink", real(folder, path, flags)); }
int mkdir(const char *path, mode_t mode) { REAL(mkdir); int folder = AT_FDCWD; ON_NAME("mkdir", real(path, mode)); }
int mkdirat(int folder, const char *path, mode_t mode) { REAL(mkdirat); ON_NAME("mkdir", real(folder, path, mode)); }

#define ON_NAMES(op, call) \
    char full[PATH_MAX], other[PATH_MAX]; \
    absolute(one, from, full); \
    if (!root_length || !is_observed(absolute(two, to, other))) return call; \
    pthread_mutex_lock(&lock); \
    int result = -1; \
    if (!fails(op, other)) { \
        result = call; \
        if (result == 0) record(op, full, other, 0, NULL, 0, -1); \
    } \
    int code = errno; \
    pthread_mutex_unlock(&lock); \
    errno = code; \
    return result

int rename(const char *from, const char *to)
{
    REAL(rename);
    int one = AT_FDCWD, two = AT_FDCWD;
    ON_NAMES("rename", real(from, to));
}

int renameat(int one, const char *from, int two, const char *to)
{
    REAL(renameat);
    ON_NAMES("rename", real(one, from, two, to));
}

int renameat2(int one, const char *from, int two, const char *to, unsigned int flags)
{
    REAL(renameat2);
    ON_NAMES(flags & RENAME_EXCHANGE ? "exchange" : "rename", real(one, from, two, to, flags));
}

int link(const char *from, const char *to)
{
    REAL(link);
    int one = AT_FDCWD, two = AT_FDCWD;
    ON_NAMES("link", real(from, to));
}
