/* Loaded into a program before all others (LD_PRELOAD), this makes the processor look as if it had no AVX-512: the instruction that
   asks for its abilities, CPUID, traps (Linux on x86-64 processors with the flag `cpuid_fault`), and the answer comes without these
   bits. Everything else runs as ever, at full speed. With SMALL_CACHE in the environment the first-level cache, too, looks half as
   large as it is.

   cc -O2 -shared -fPIC -o without-avx512.so without-avx512.c */
#define _GNU_SOURCE
#include <cpuid.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#define ARCH_SET_CPUID 0x1012

/* bits of leaf 7: foundation, DQ, IFMA, PF, ER, CD, BW, VL; VBMI, VBMI2, VNNI, BITALG, VPOPCNTDQ; 4VNNIW, 4FMAPS, VP2INTERSECT,
   AMX-BF16, FP16, AMX-TILE, AMX-INT8; BF16 */
#define LEAF_7_EBX (1u << 16 | 1u << 17 | 1u << 21 | 1u << 26 | 1u << 27 | 1u << 28 | 1u << 30 | 1u << 31)
#define LEAF_7_ECX (1u << 1 | 1u << 6 | 1u << 11 | 1u << 12 | 1u << 14)
#define LEAF_7_EDX (1u << 2 | 1u << 3 | 1u << 8 | 1u << 22 | 1u << 23 | 1u << 24 | 1u << 25)
#define LEAF_7_1_EAX (1u << 5)

static int small_cache;

static void trapped(int signal_number, siginfo_t *info, void *context)
{
    (void)info;
    greg_t *registers = ((ucontext_t *)context)->uc_mcontext.gregs;
    const unsigned char *instruction = (const unsigned char *)registers[REG_RIP];
    if (instruction[0] != 0x0f || instruction[1] != 0xa2) {
        /* no CPUID: what a program without this would get */
        signal(signal_number, SIG_DFL);
        return;
    }
    unsigned leaf = (unsigned)registers[REG_RAX], part = (unsigned)registers[REG_RCX];
    unsigned eax, ebx, ecx, edx;
    syscall(SYS_arch_prctl, ARCH_SET_CPUID, 1);
    __cpuid_count(leaf, part, eax, ebx, ecx, edx);
    syscall(SYS_arch_prctl, ARCH_SET_CPUID, 0);
    if (leaf == 7 && part == 0) {
        ebx &= ~LEAF_7_EBX;
        ecx &= ~LEAF_7_ECX;
        edx &= ~LEAF_7_EDX;
    }
    if (leaf == 7 && part == 1)
        eax &= ~LEAF_7_1_EAX;
    /* ways of a cache of the first level, less one, in the upper ten bits */
    if (leaf == 4 && small_cache && (eax >> 5 & 7) == 1)
        ebx = (ebx & 0x3fffff) | ((((ebx >> 22) + 1) / 2 - 1) << 22);
    registers[REG_RAX] = eax;
    registers[REG_RBX] = ebx;
    registers[REG_RCX] = ecx;
    registers[REG_RDX] = edx;
    registers[REG_RIP] += 2;
}

__attribute__((constructor)) static void begin(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_sigaction = trapped;
    action.sa_flags = SA_SIGINFO | SA_NODEFER | SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    small_cache = getenv("SMALL_CACHE") != NULL;
    if (sigaction(SIGSEGV, &action, NULL) != 0 || syscall(SYS_arch_prctl, ARCH_SET_CPUID, 0) != 0) {
        static const char message[] = "this system does not let CPUID trap\n";
        if (write(STDERR_FILENO, message, sizeof message - 1) < 0)
            _exit(3);
        _exit(2);
    }
}
